//! Structures that are taken from one frame to the next, and not built anew.

use accel_core::primitives::PrimitiveError;
use accel_core::registry::Buildable;
use glam::DVec3;

use super::{on_edge, point_within, soup_round, toward};
use crate::case;
use crate::verify::draw::{one_of, point, single, unit};
use crate::verify::meshes::soup;
use crate::verify::model::{Corners, Model};
use crate::verify::registry::Case;
use crate::verify::round::Round;
use statistics::random::Random;

pub const Q11: Case = case!(
    "Q11",
    "exact",
    frames,
    "refits and updates between frames: few or all triangles moved, far away, shrunk to points",
    1,
    &[
        "wide-bvh update=refit",
        "wide-bvh update=refit rebuild-at=1000000000",
        "obvhs-bvh2 update=refit",
        "obvhs-bvh2 update=refit rebuild-at=1000000000",
        "uniform-grid update=incremental",
        "hashed-grid update=incremental",
        "two-level-grid update=incremental",
        "instanced-bvh update=instances",
        "instanced-grid update=instances",
    ]
);

fn frames<S: Buildable>(random: &mut Random, rays: usize) -> Result<Round<S>, PrimitiveError> {
    let before = soup(random, 150, 0.4);
    let share = one_of(random, &[0.02, 0.3, 1.0]);
    let way = one_of(random, &[1e-3, 0.5, 30.0]);
    let kind = random.below(3);
    let moved = |random: &mut Random, triangle: &Corners| {
        if unit(random) >= share {
            return *triangle;
        }
        let by = point(random) * way;
        match kind {
            0 => triangle.map(|p| p + by),
            // points, and what was one before
            1 => [triangle[0]; 3],
            _ => [(); 3].map(|()| point(random) + by),
        }
        .map(single)
    };
    let after: Vec<Corners> = before.iter().map(|t| moved(random, t)).collect();
    let (before, after) = if random.below(2) == 0 { (before, after) } else { (after, before) };
    let mut round = soup_round(random, rays, &after, |random| {
        let target: DVec3 = match random.below(2) {
            0 => point_within(random, &after),
            _ => on_edge(random, &after),
        };
        toward(random, target, 2.0)
    })?;
    round.before = Some(Model::triangles(&before)?);
    Ok(round)
}
