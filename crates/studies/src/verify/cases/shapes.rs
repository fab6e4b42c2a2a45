//! Spheres and cones.

use accel_core::Ray;
use accel_core::primitives::{Cone, PrimitiveError};
use accel_core::registry::Buildable;
use glam::{DVec3, dvec3};

use crate::case;
use crate::verify::closed_form::ConeShape;
use crate::verify::draw::{direction, one_of, point, single, unit};
use crate::verify::model::Model;
use crate::verify::registry::Case;
use crate::verify::round::{OracleAnswer, Round, ray};
use statistics::random::Random;

pub const G9: Case = case!("G9", "closed form", small_far_sphere, "a small sphere seen from afar");
pub const G10: Case = case!(
    "G10",
    "closed form",
    spheres_within,
    "rays from within a sphere, just above a huge one, at a point, along a tangent"
);
pub const G11: Case = case!(
    "G11",
    "twice the digits",
    cones,
    "cones and cylinders: along the axis, through the apex, from within, without height"
);
/// The rim of G11.
pub const G11_RIM: Case = case!(
    "G11rim",
    "twice the digits",
    rims,
    "rays at the rim where two parts of a cone or cylinder meet: no gap"
);
fn small_far_sphere<S: Buildable>(
    random: &mut Random,
    rays: usize,
) -> Result<Round<S>, PrimitiveError> {
    const RADIUS: f64 = 0.1;
    let model = Model::mixed(|set| set.sphere(DVec3::ZERO, RADIUS))?;
    let mut round = Round::new(model);
    for _ in 0..rays {
        let far = one_of(random, &[1e2, 1e3, 1e4, 1e5, 1e6]);
        let offset: f64 = one_of(random, &[0.095, 0.105]);
        let (axis, sign) = (random.below(3), one_of(random, &[1.0, -1.0]));
        let turned = |v: DVec3| match axis {
            0 => v,
            1 => dvec3(v.z, v.x, v.y),
            _ => dvec3(v.y, v.z, v.x),
        };
        let depth = (RADIUS * RADIUS - offset * offset).max(0.0).sqrt();
        let hit = OracleAnswer::hit_at(far - depth, far * 4.0 * f64::from(f32::EPSILON));
        let expected = if offset < RADIUS { hit } else { OracleAnswer::Miss };
        let ray = ray(turned(dvec3(-sign * far, offset, 0.0)), turned(dvec3(sign, 0.0, 0.0)));
        round.push(ray, expected);
    }
    Ok(round)
}

fn spheres_within<S: Buildable>(
    random: &mut Random,
    rays: usize,
) -> Result<Round<S>, PrimitiveError> {
    let radius: f64 = one_of(random, &[1.0, 1e6]);
    let model = Model::mixed(|set| set.sphere(DVec3::ZERO, radius))?;
    let mut round = Round::new(model);
    for _ in 0..rays {
        let toward = direction(random);
        let (origin, along) = match random.below(2) {
            // through the centre from within: the way out is the radius and what was gone
            0 => (toward * radius * -0.5, toward),
            _ => (toward * (radius + radius.min(1.0)), -toward),
        };
        let ray = ray(origin, along);
        // as they were rounded
        let (o, d) = (single(origin), single(along));
        let (a, b) = (d.dot(d), o.dot(d));
        let root = (b * b - a * (o.dot(o) - radius * radius)).sqrt();
        let t = if o.length() < radius { (root - b) / a } else { (-root - b) / a };
        // what the rounding of the origin changes
        let slack = if radius > 1.0 { radius * 3e-7 } else { 1e-5 };
        round.push(ray, OracleAnswer::hit_at(t, slack));
    }
    Ok(round)
}

/// A cone, a cylinder, a truncated cone or one without height, alone in its scene.
fn cones<S: Buildable>(random: &mut Random, rays: usize) -> Result<Round<S>, PrimitiveError> {
    around_cone(random, rays, false)
}

/// The same in two parts of half the height.
fn rims<S: Buildable>(random: &mut Random, rays: usize) -> Result<Round<S>, PrimitiveError> {
    around_cone(random, rays, true)
}

fn around_cone<S: Buildable>(
    random: &mut Random,
    rays: usize,
    is_split: bool,
) -> Result<Round<S>, PrimitiveError> {
    let axis = one_of(random, &[DVec3::X, DVec3::Y, DVec3::Z, -DVec3::Z, dvec3(0.6, 0.0, 0.8)]);
    let base = single(point(random));
    let (radii, height): ([f64; 2], f64) = one_of(
        random,
        &[([1.0, 0.0], 1.0), ([0.5, 0.5], 2.0), ([0.25, 1.0], 1.0), ([1.0, 0.5], 0.0)],
    );
    let apex = single(base + axis * height);
    let shape = ConeShape { base: (base, radii[0]), apex: (apex, radii[1]) };
    let model = Model::mixed(|set| {
        let middle = ((base + apex) / 2.0, (radii[0] + radii[1]) / 2.0);
        if !is_split {
            return set.cone(Cone::new(base, radii[0], apex, radii[1]));
        }
        set.cone(Cone::new(base, radii[0], middle.0, middle.1))?;
        set.cone(Cone::new(middle.0, middle.1, apex, radii[1]))
    })?;
    let magnitude = model.magnitude();
    let mut round = Round::new(model);
    let across = axis.any_orthonormal_vector();
    for _ in 0..rays {
        let turn = unit(random) * std::f64::consts::TAU;
        let out = across * turn.cos() + axis.cross(across) * turn.sin();
        let at = base + axis * (height * unit(random));
        let (origin, along) = match random.below(6) {
            // parallel to the axis
            0 => {
                let sign = one_of(random, &[1.0, -1.0]);
                (at + out * unit(random) - axis * (sign * 4.0), axis * sign)
            }
            // at the apex
            1 => (apex + point(random) * 3.0, apex),
            // at the middle, where the rim of two parts is
            2 => (base + axis * (height / 2.0) + out * 3.0, (base + apex) / 2.0),
            // from within
            3 => (at + out * (unit(random) * 0.2), at + point(random)),
            // at the surface
            4 => (at + point(random) * 4.0, at + out * radii[0].max(radii[1])),
            _ => (at + point(random) * 4.0, at + point(random)),
        };
        let origin = single(origin);
        let is_axial = along.distance(axis) < 1e-9 || along.distance(-axis) < 1e-9;
        let along = single(if is_axial { along } else { along - origin });
        let ray: Ray<S> = ray(origin, along);
        if !ray.is_traceable() {
            continue;
        }
        round.push(ray, shape.expected(&ray, magnitude));
    }
    Ok(round)
}
