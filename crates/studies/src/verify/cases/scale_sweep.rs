//! The whole served range of scales, power of two by power of two: bits must stay.
//!
//! A sparse set of scales passes over a fault at one of them. Each round tries one exponent from
//! each of [`PARTS`] equal parts of the served range: a few rounds try all of f32, a few hundred
//! all of f64.

use accel_core::primitives::PrimitiveError;
use accel_core::registry::Buildable;
use glam::DVec3;

use super::{point_within, soup_round, toward};
use crate::case;
use crate::verify::draw::one_of;
use crate::verify::meshes::{icosphere, sheet, soup, torus};
use crate::verify::metamorphic::OriginalScene;
use crate::verify::model::Corners;
use crate::verify::registry::Case;
use crate::verify::round::Round;
use statistics::random::Random;

/// Oracle K of the catalogue, densely.
pub const K1_DENSE: Case = case!(
    "K1dense",
    "scaled",
    scaled,
    "the whole scene times every power of two that is served: identical bits",
    20,
    &[]
);

/// Scales of a round.
const PARTS: usize = 16;

fn scaled<S: Buildable>(random: &mut Random, rays: usize) -> Result<Round<S>, PrimitiveError> {
    let triangles: Vec<Corners> = match random.below(4) {
        0 => soup(random, 80, 0.3),
        1 => icosphere(1, DVec3::ZERO),
        2 => torus(12, 6),
        _ => {
            let level = one_of(random, &[0.0, 0.5]);
            let small = |t: &Corners| t.map(|p| (p / 4.0 - 1.0).with_z(level));
            sheet(8, |_, _| 0.0).iter().map(small).collect()
        }
    };
    let mut round: Round<S> = soup_round(random, rays, &triangles, |random| {
        let target = point_within(random, &triangles);
        toward(random, target, 2.0)
    })?;
    let original = OriginalScene { triangles: &triangles, rays: &round.rays };
    let largest = triangles.as_flattened().iter().fold(0.0, |m, p| p.abs().max_element().max(m));
    // what lies within the served exponents is refused on neither side
    let own = f64::log2(largest).floor() as i32;
    let [low, high] = S::SCENE_EXPONENTS.map(|e| e - own);
    let parts = PARTS.min((high - low) as usize);
    let edge = |i: usize| low + ((high - low) as usize * i / parts) as i32;
    let one_of_part = |i| {
        let [from, to] = [edge(i), edge(i + 1)];
        from + random.below((to - from) as usize) as i32
    };
    let exponents: Vec<i32> = (0..parts).map(one_of_part).collect();
    round.pairs = exponents.into_iter().filter_map(|e| original.scaled(e)).collect();
    Ok(round)
}
