//! Cones and cylinders a hundred to a hundred thousand times as long as wide, and as flat ones.

use accel_core::Ray;
use accel_core::primitives::{Cone, PrimitiveError};
use accel_core::registry::Buildable;
use glam::{DQuat, DVec3};

use crate::case;
use crate::verify::closed_form::{ConeShape, first_of};
use crate::verify::draw::{direction, one_of, point, signed, single, unit};
use crate::verify::every_hit::every_hit;
use crate::verify::model::Model;
use crate::verify::own_bounds::out_of_padded_box;
use crate::verify::registry::Case;
use crate::verify::round::{OracleAnswer, Round, ray};
use statistics::random::Random;

pub const Q3: Case = case!(
    "Q3",
    "twice the digits, own bounds",
    slender_cones,
    "cones and cylinders of 100:1 to 100,000:1, seen near an end and at their silhouette"
);
/// The same, as wide as they are long and much wider.
pub const Q3_FLAT: Case = case!(
    "Q3flat",
    "twice the digits, own bounds",
    flat_cones,
    "cones up to 100,000 times as wide as long, and rays along their surface"
);

fn slender_cones<S: Buildable>(
    random: &mut Random,
    rays: usize,
) -> Result<Round<S>, PrimitiveError> {
    let length = one_of(random, &[1.0, 10.0, 100.0]);
    let ratio = 10f64.powf(2.0 + 3.0 * unit(random));
    cone_round(random, rays, length, length / ratio)
}

fn flat_cones<S: Buildable>(random: &mut Random, rays: usize) -> Result<Round<S>, PrimitiveError> {
    let radius = one_of(random, &[1.0, 10.0, 100.0]);
    let ratio = 10f64.powf(5.0 * unit(random));
    cone_round(random, rays, radius / ratio, radius)
}

/// Some cones of about that length and radius, in any direction.
fn cone_round<S: Buildable>(
    random: &mut Random,
    rays: usize,
    length: f64,
    radius: f64,
) -> Result<Round<S>, PrimitiveError> {
    let size = length.max(radius);
    let away = direction(random) * size * one_of(random, &[0.0, 0.0, 1.0, 10.0]);
    let many = 1 + random.below(6);
    let shapes: Vec<ConeShape> = (0..many).map(|_| shape(random, length, radius, away)).collect();
    let model = Model::mixed(|set| {
        shapes.iter().try_for_each(|s| set.cone(Cone::new(s.base.0, s.base.1, s.apex.0, s.apex.1)))
    })?;
    let magnitude = model.magnitude();
    let mut round = Round::new(model);
    while round.rays.len() < rays {
        let shape: ConeShape = one_of(random, &shapes);
        let (origin, target) = aim(random, &shape, size);
        let origin = single(origin);
        let ray: Ray<S> = ray(origin, target - origin);
        // farther origins are brought near before they are asked
        if !ray.is_traceable() || origin.abs().max_element() > 7.0 * magnitude {
            continue;
        }
        let hits = every_hit(&round.model, &ray);
        let expected = match out_of_padded_box(&round.model, &ray, &hits) {
            Some(fault) => OracleAnswer::Broken(fault),
            None => first_of((0..).zip(&shapes).map(|(id, s)| (id, s.expected(&ray, magnitude)))),
        };
        round.push(ray, expected);
    }
    Ok(round)
}

fn shape(random: &mut Random, length: f64, radius: f64, away: DVec3) -> ConeShape {
    let held = |x: f64| f64::from(x as f32);
    let base = single(away + point(random) * length.max(radius));
    let any = direction(random);
    let axis = one_of(random, &[DVec3::X, DVec3::Y, -DVec3::Z, any]);
    let other = held(radius * one_of(random, &[1.0, 1.0, 0.5, 0.0]));
    let (mut radii, apex) = ([held(radius), other], single(base + axis * length));
    if random.below(2) == 0 {
        radii.reverse();
    }
    // the inside is seen
    let sign = one_of(random, &[1.0, 1.0, 1.0, -1.0]);
    ConeShape { base: (base, radii[0] * sign), apex: (apex, radii[1] * sign) }
}

/// Origin of a ray, and a point that it passes through.
fn aim(random: &mut Random, shape: &ConeShape, size: f64) -> (DVec3, DVec3) {
    let axis = shape.apex.0 - shape.base.0;
    let unit_axis = axis.normalize_or(DVec3::Z);
    let turn = unit(random) * std::f64::consts::TAU;
    let out = DQuat::from_axis_angle(unit_axis, turn) * unit_axis.any_orthonormal_vector();
    let any = unit(random);
    let height = one_of(random, &[0.0, 0.01, 0.99, 1.0, any]);
    let radius = shape.base.1 + (shape.apex.1 - shape.base.1) * height;
    let surface = shape.base.0 + axis * height + out * radius.abs();
    // at the silhouette, a little within or beyond it, or anywhere between
    let off = one_of(random, &[0.0, 1e-4, -1e-4, 1e-2, -1e-2, -0.5, -1.0, -any]);
    let target = surface + out * (radius.abs() * off);
    let across = unit_axis.cross(out);
    let along = match random.below(4) {
        // across the axis, along the tangent
        0 => across + unit_axis * signed(random),
        // nearly along the axis
        1 => unit_axis + direction(random) * 10f64.powf(-4.0 * unit(random)),
        // nearly along the surface
        2 => {
            let line = axis + out * (shape.apex.1.abs() - shape.base.1.abs());
            let tilt = out * 10f64.powf(-1.0 - 6.0 * unit(random));
            line.normalize_or_zero() - tilt + across * (0.1 * signed(random))
        }
        _ => direction(random),
    };
    let sign = one_of(random, &[1.0, -1.0]);
    (target + along * (sign * size * (0.2 + 2.0 * unit(random))), target)
}
