//! Spheres, cones and cylinders, also very slender and very flat ones.

use accel_core::primitives::Cone;
use glam::DQuat;

use super::*;
use crate::verify::closed_form::{ConeShape, first_of};
use crate::verify::every_hit::outside_box;

pub fn small_far_sphere<S: Buildable>(random: &mut Random, rays: usize) -> RoundResult<S> {
    const RADIUS: f64 = 0.1;
    let model = mixed_model(|set| set.sphere(DVec3::ZERO, RADIUS))?;
    let mut round = Round::new(model);
    for _ in 0..rays {
        let far = one_of(random, &[1e2, 1e3, 1e4, 1e5, 1e6]);
        let offset: f64 = one_of(random, &[0.095, 0.105]);
        let (axis, sign) = (random.below(3), one_of(random, &[1.0, -1.0]));
        let depth = (RADIUS * RADIUS - offset * offset).max(0.0).sqrt();
        let hit = OracleAnswer::hit_at(far - depth, far * 4.0 * f64::from(f32::EPSILON));
        let expected = if offset < RADIUS { hit } else { OracleAnswer::Miss };
        let [origin, along] = [[-sign * far, offset, 0.0], [sign, 0.0, 0.0]]
            .map(|v| DVec3::from(turned(v, 3 - axis)));
        round.push(ray(origin, along), expected);
    }
    Ok(round)
}

pub fn spheres_within<S: Buildable>(random: &mut Random, rays: usize) -> RoundResult<S> {
    let radius: f64 = one_of(random, &[1.0, 1e6]);
    let model = mixed_model(|set| set.sphere(DVec3::ZERO, radius))?;
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
pub fn cones<S: Buildable>(random: &mut Random, rays: usize) -> RoundResult<S> {
    around_cone(random, rays, false)
}

/// The same in two parts of half the height.
pub fn rims<S: Buildable>(random: &mut Random, rays: usize) -> RoundResult<S> {
    around_cone(random, rays, true)
}

fn around_cone<S: Buildable>(random: &mut Random, rays: usize, is_split: bool) -> RoundResult<S> {
    let axis = one_of(random, &[DVec3::X, DVec3::Y, DVec3::Z, -DVec3::Z, dvec3(0.6, 0.0, 0.8)]);
    let base = single(point(random));
    let (radii, height): ([f64; 2], f64) = one_of(
        random,
        &[([1.0, 0.0], 1.0), ([0.5, 0.5], 2.0), ([0.25, 1.0], 1.0), ([1.0, 0.5], 0.0)],
    );
    let apex = single(base + axis * height);
    let shape = ConeShape { base: (base, radii[0]), apex: (apex, radii[1]) };
    let model = mixed_model(|set| {
        let middle = ((base + apex) / 2.0, (radii[0] + radii[1]) / 2.0);
        if !is_split {
            return set.cone(Cone::new(base, radii[0], apex, radii[1]));
        }
        set.cone(Cone::new(base, radii[0], middle.0, middle.1))?;
        set.cone(Cone::new(middle.0, middle.1, apex, radii[1]))
    })?;
    let magnitude = magnitude(&model);
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
        round.push_traceable(ray, |_| shape.expected(&ray, magnitude));
    }
    Ok(round)
}

pub fn slender_cones<S: Buildable>(random: &mut Random, rays: usize) -> RoundResult<S> {
    let length = one_of(random, &[1.0, 10.0, 100.0]);
    let ratio = 10f64.powf(2.0 + 3.0 * unit(random));
    cone_rays(random, rays, length, length / ratio)
}

pub fn flat_cones<S: Buildable>(random: &mut Random, rays: usize) -> RoundResult<S> {
    let radius = one_of(random, &[1.0, 10.0, 100.0]);
    let ratio = 10f64.powf(5.0 * unit(random));
    cone_rays(random, rays, radius / ratio, radius)
}

/// Some cones of about that length and radius, in any direction.
fn cone_rays<S: Buildable>(
    random: &mut Random,
    rays: usize,
    length: f64,
    radius: f64,
) -> RoundResult<S> {
    let size = length.max(radius);
    let away = direction(random) * size * one_of(random, &[0.0, 0.0, 1.0, 10.0]);
    let many = 1 + random.below(6);
    let shapes: Vec<ConeShape> = (0..many).map(|_| shape(random, length, radius, away)).collect();
    let model = mixed_model(|set| {
        shapes.iter().try_for_each(|s| set.cone(Cone::new(s.base.0, s.base.1, s.apex.0, s.apex.1)))
    })?;
    let magnitude = magnitude(&model);
    Ok(Round::new(model).filled(rays, |round| {
        let shape: ConeShape = one_of(random, &shapes);
        let (origin, target) = aim(random, &shape, size);
        let origin = single(origin);
        let ray: Ray<S> = ray(origin, target - origin);
        // farther origins are brought near before they are asked
        if origin.abs().max_element() > 7.0 * magnitude {
            return;
        }
        let each = || (0..).zip(&shapes).map(|(id, shape)| (id, shape.expected(&ray, magnitude)));
        round.push_traceable(ray, |round| {
            let fault = outside_box(&round.model, &ray, &every_hit(&round.model, &ray));
            fault.map_or_else(|| first_of(each()), OracleAnswer::Broken)
        });
    }))
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
