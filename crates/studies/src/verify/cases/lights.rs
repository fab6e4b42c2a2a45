//! Shadow rays to lights in awkward places: on a surface, at a vertex, in a plane, inside a body,
//! far away.

use accel_core::Ray;
use accel_core::primitives::PrimitiveError;
use accel_core::registry::Buildable;
use glam::DVec3;

use super::{on_edge, point_within};
use crate::case;
use crate::verify::draw::{direction, one_of, point, signed, single, unit};
use crate::verify::every_hit::{every_hit, first_within};
use crate::verify::meshes::{icosphere, soup};
use crate::verify::model::{Corners, Model};
use crate::verify::registry::Case;
use crate::verify::round::{Round, ray};
use statistics::random::Random;

pub const Q10: Case = case!(
    "Q10",
    "all tests",
    lights,
    "shadow rays to a light on a surface, at a vertex, in a plane, inside, or 10^9 away"
);
/// The same for what answers shadow rays alone.
pub const Q10_OCCLUDERS: Case = case!(
    "Q10occluders",
    "all tests",
    lights,
    "the same, asked of structures for shadow rays alone",
    2,
    &[
        "light-buffer",
        "light-buffer query=batch",
        "light-buffer resolution=64",
        "light-buffer fill=demand resolution=32",
        "light-buffer resolution=128 cut-off=none",
    ]
);

/// Lights of a round.
const LIGHTS: usize = 3;

fn lights<S: Buildable>(random: &mut Random, rays: usize) -> Result<Round<S>, PrimitiveError> {
    let size = one_of(random, &[0.2, 0.8]);
    let triangles: Vec<Corners> = match random.below(3) {
        0 => icosphere(2, DVec3::ZERO),
        1 => soup(random, 120, size),
        _ => soup(random, 80, size).iter().map(|t| t.map(|p| p.with_z(0.25))).collect(),
    };
    let has_balls = random.below(2) == 0;
    let mut round = Round::new(if has_balls {
        Model::mixed(|set| {
            triangles.iter().try_for_each(|t| set.triangle(*t))?;
            (0..6).try_for_each(|_| set.sphere(point(random), 0.05 + 0.3 * unit(random)))
        })?
    } else {
        Model::<S>::triangles(&triangles)?
    });
    round.lights = (0..LIGHTS).map(|_| light(random, &triangles)).collect();
    while round.rays.len() < rays {
        let number = random.below(LIGHTS);
        let light = round.lights[number];
        let target = match random.below(3) {
            0 => point(random) * 1.5,
            1 => on_edge(random, &triangles),
            _ => point_within(random, &triangles),
        };
        // to the light, from a surface or anywhere
        let origin = single(target);
        let part = one_of(random, &[1.0, 1.0 - 1e-6, 0.999]);
        let ray: Ray<S> = ray(origin, light - origin);
        let [t_min, t_max] = [one_of(random, &[0.0, 1e-6, 1e-3]), part].map(S::from_f64);
        let ray = Ray { t_min, t_max, ..ray };
        if !ray.is_traceable() {
            continue;
        }
        let hits = every_hit(&round.model, &ray);
        round.push(ray, first_within(&hits, t_min, t_max));
        round.blocked.push(!hits.is_empty());
        round.light_of.push(number as u32);
    }
    Ok(round)
}

fn light(random: &mut Random, triangles: &[Corners]) -> DVec3 {
    let [a, b, c]: Corners = one_of(random, triangles);
    let light = match random.below(6) {
        0 => point_within(random, triangles),
        1 => a,
        // in the plane of a triangle
        2 => a + (b - a) * (3.0 * signed(random)) + (c - a) * (3.0 * signed(random)),
        3 => point(random) * 0.1,
        4 => direction(random) * 1e9,
        _ => point(random) * 3.0,
    };
    single(light)
}
