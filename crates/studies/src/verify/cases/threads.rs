//! Scenes that are large enough to be built by several threads.

use accel_core::primitives::PrimitiveError;
use accel_core::registry::Buildable;

use super::{point_within, soup_round, toward};
use crate::case;
use crate::verify::meshes::soup;
use crate::verify::registry::Case;
use crate::verify::round::Round;
use statistics::random::Random;

pub const K3: Case = case!(
    "K3",
    "exact, one thread",
    threads,
    "13,000 triangles, built by one thread and by three: the same answers",
    100,
    &[
        "wide-bvh",
        "wide-bvh preset=morton",
        "kd-tree",
        "octree",
        "uniform-grid",
        "two-level-grid",
        "recursive-grid",
        "hug",
        "adaptive-grid",
        "irregular-grid",
        "hashed-grid",
        "proximity-clouds",
        "kay-kajiya",
        "bounding-volumes",
        "obvhs-cwbvh",
    ]
);

/// Enough for three parts.
const TRIANGLES: usize = 13_000;

fn threads<S: Buildable>(random: &mut Random, rays: usize) -> Result<Round<S>, PrimitiveError> {
    let triangles = soup(random, TRIANGLES, 0.05);
    let mut round = soup_round(random, rays, &triangles, |random| {
        let target = point_within(random, &triangles);
        toward(random, target, 2.0)
    })?;
    round.threads = &[1, 3];
    Ok(round)
}
