//! Intervals of every kind: behind the origin, of one ulp, of one number, and begun anew after each
//! hit.
//!
//! A ray's interval is closed, and nothing forbids that it begins below 0. The hits of the whole
//! line are found by testing each primitive alone; what each interval holds of them follows.

use accel_core::primitives::PrimitiveError;
use accel_core::registry::Buildable;
use accel_core::{Hit, Ray, Scalar};
use glam::DVec3;

use super::{point_within, toward};
use crate::case;
use crate::verify::draw::{one_of, point, signed, single, unit};
use crate::verify::every_hit::{every_hit, first_within, push_chain};
use crate::verify::meshes::{icosphere, soup};
use crate::verify::model::{Corners, Model};
use crate::verify::registry::Case;
use crate::verify::round::{Round, ray};
use statistics::random::Random;

/// Adapters of libraries clamp intervals.
pub const R8: Case = case!(
    "R8",
    "all tests",
    intervals,
    "intervals below 0, of one ulp, of one number; chains of hits: each once, in order"
);

/// Links of a chain that are asked.
const LINKS: usize = 40;

fn intervals<S: Buildable>(random: &mut Random, rays: usize) -> Result<Round<S>, PrimitiveError> {
    let (model, targets) = scene(random)?;
    let mut round = Round::new(model);
    while round.rays.len() < rays {
        let target = point_within(random, &targets);
        let (mut origin, along) = toward(random, target, 2.0);
        if random.below(2) == 0 {
            // beyond the target, which then lies behind
            origin = single(target + along * (0.1 + unit(random)));
        }
        let whole = Ray { t_min: S::from_f64(-1e30), ..ray::<S>(origin, along) };
        if !whole.is_traceable() {
            continue;
        }
        let hits = every_hit(&round.model, &whole);
        if random.below(3) == 0 {
            let start = one_of(random, &[-1e30, -2.0, 0.0]);
            push_chain(&mut round, Ray { t_min: S::from_f64(start), ..whole }, &hits, LINKS);
            continue;
        }
        let [t_min, t_max] = interval(random, &hits);
        round.push(Ray { t_min, t_max, ..whole }, first_within(&hits, t_min, t_max));
    }
    round.rays.truncate(rays);
    round.expected.truncate(rays);
    Ok(round)
}

/// An interval at one of the hits, or anywhere.
fn interval<S: Scalar>(random: &mut Random, hits: &[Hit<S>]) -> [S; 2] {
    let any = S::from_f64(signed(random) * 3.0);
    let t = hits.get(random.below(hits.len())).map_or(any, |hit| hit.t);
    let below = S::from_f64(one_of(random, &[-1e30, -1e3, -2.0, -0.1, -1e-30]));
    match random.below(8) {
        0 => [t, t],
        1 => [t.next_down(), t],
        2 => [t, t.next_up()],
        3 => [t.next_up(), t.next_up().next_up()],
        4 => [t.next_down().next_down(), t.next_down()],
        5 => [below, S::INFINITY],
        6 => [below, S::from_f64(below.to_f64() * unit(random))],
        _ => [any, any + S::from_f64(unit(random))],
    }
}

/// A scene, and triangles to aim at.
pub(super) fn scene<S: Scalar>(
    random: &mut Random,
) -> Result<(Model<S>, Vec<Corners>), PrimitiveError> {
    let triangles = match random.below(4) {
        0 => icosphere(2, DVec3::ZERO),
        1 => soup(random, 150, 0.4),
        2 => {
            // in pairs: all hits tie
            let mut twice = soup(random, 60, 0.6);
            twice.extend_from_within(..);
            random.shuffle(&mut twice);
            twice
        }
        _ => {
            let triangles = soup(random, 60, 0.5);
            let model = Model::mixed(|set| {
                for &triangle in &triangles {
                    set.triangle(triangle)?;
                    set.sphere(point(random), 0.05 + 0.4 * unit(random))?;
                }
                Ok(())
            })?;
            return Ok((model, triangles));
        }
    };
    Ok((Model::triangles(&triangles)?, triangles))
}
