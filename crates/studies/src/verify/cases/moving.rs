//! Rays with a time over triangles that move, neighbours in opposite directions.

use accel_core::Ray;
use accel_core::primitives::PrimitiveError;
use accel_core::registry::Buildable;
use glam::DVec3;

use super::{on_edge, point_within, toward};
use crate::case;
use crate::verify::draw::{direction, one_of, unit};
use crate::verify::exact::Soup;
use crate::verify::expect::in_soup;
use crate::verify::meshes::soup;
use crate::verify::model::{Corners, Model};
use crate::verify::registry::Case;
use crate::verify::round::{OracleAnswer, Round, ray};
use statistics::random::Random;

pub const Q7: Case = case!(
    "Q7",
    "exact at each time",
    moving,
    "rays with a time: opposite velocities, exposures of 2^-80 to 2^80, borders of segments, NaN"
);
/// The same with a structure for each part of the exposure.
pub const Q7_SEGMENTS: Case = case!(
    "Q7segments",
    "exact at each time",
    moving,
    "the same with several structures, each over a part of the exposure",
    1,
    &[
        "wide-bvh time-segments=4",
        "obvhs-cwbvh time-segments=3",
        "uniform-grid time-segments=8",
        "kd-tree time-segments=5",
        "octree time-segments=2",
        "irregular-grid time-segments=4",
    ]
);

/// Times of a round: the scene is made anew for each.
const TIMES: usize = 12;

fn moving<S: Buildable>(random: &mut Random, rays: usize) -> Result<Round<S>, PrimitiveError> {
    let exposure = one_of(random, &[1.0, 0.75, (-80f64).exp2(), 80f64.exp2()]);
    let size = one_of(random, &[0.1, 0.4, 1.0]);
    let triangles = soup(random, 60, size);
    let way = direction(random) * one_of(random, &[1e-3, 0.5, 2.0]);
    let ways: Vec<DVec3> = (0..triangles.len())
        .map(|_| {
            let other = direction(random) * unit(random);
            let way = one_of(random, &[way, -way, way, -way, DVec3::ZERO, other]);
            // as it is held, in units of the exposure
            (way / exposure).as_vec3().as_dvec3()
        })
        .collect();
    let mut round = Round::new(Model::mixed(|set| {
        triangles.iter().zip(&ways).try_for_each(|(triangle, way)| {
            set.triangle(*triangle)?;
            set.last_moves(*way, exposure)
        })
    })?);
    for _ in 0..TIMES {
        let time = time::<S>(random, exposure);
        // what moves stands still before its exposure and after it
        let moment = if time.to_f64() > 0.0 { time.to_f64().min(exposure) } else { 0.0 };
        let now: Vec<Corners> =
            triangles.iter().zip(&ways).map(|(t, way)| t.map(|p| p + *way * moment)).collect();
        let exact = Soup::new(&now);
        for _ in 0..rays.div_ceil(TIMES) {
            let target = match random.below(2) {
                0 => point_within(random, &now),
                _ => on_edge(random, &now),
            };
            let (origin, along) = toward(random, target, 3.0);
            let ray: Ray<S> = Ray { time, ..ray(origin, along) };
            round.push(ray, in_soup(&exact, &ray).unwrap_or(OracleAnswer::Anything));
        }
    }
    round.rays.truncate(rays);
    round.expected.truncate(rays);
    Ok(round)
}

/// At a border of equal parts of the exposure, an ulp beside, anywhere, outside, or no time.
fn time<S: Buildable>(random: &mut Random, exposure: f64) -> S {
    let parts = 1 + random.below(8);
    let border = S::from_f64(exposure * random.below(parts + 1) as f64 / parts as f64);
    let beyond = one_of(random, &[-1.0, -1e-30, 1.5, 1e6, f64::INFINITY, f64::NAN]);
    match random.below(6) {
        0 => border.next_up(),
        1 => border.next_down(),
        2 => S::from_f64(exposure * beyond),
        3 => S::from_f64(exposure * unit(random)),
        _ => border,
    }
}
