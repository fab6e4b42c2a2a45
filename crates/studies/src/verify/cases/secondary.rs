//! Rays that leave surfaces: they must neither hit what they leave nor miss what stands close.
//!
//! The rays are made as the renderer makes them, from hits that brute force found, by an offset rule
//! of choice; `verify` asks for the default one.

use renderer::ray_offset::{OffsetRule, RayOffset};
use renderer::surface::{SurfacePoint, Surfaces};
use scene_loading::{Cone, Scene};

use super::*;
use crate::verify::subject::with_brute_force;

/// Rays that leave one hit point.
const A_HIT: usize = 20;

/// Draws a round whose rays leave surfaces under a rule.
pub type Draw<S> = fn(&mut Random, usize, OffsetRule) -> RoundResult<S>;

/// The cases by name, under a rule of choice: with none, rays hit what they leave. Each draws the
/// same scenes and the same number of rays for each rule.
pub fn draws<S: Buildable>() -> [(&'static str, Draw<S>); 5] {
    [
        ("S1", from_a_shape),
        ("S2", from_far_away),
        ("S3", between_planes),
        ("S3ball", under_a_ball),
        ("S4", to_a_light_on_a_surface),
    ]
}

pub fn from_a_shape<S: Buildable>(
    random: &mut Random,
    rays: usize,
    rule: OffsetRule,
) -> RoundResult<S> {
    let size = 10.0_f64.powf(unit(random) * 16.0 - 8.0);
    let at = point(random) * size * one_of(random, &[0.0, 1.0, 10.0, 1000.0]);
    let (mut scene, material) = Scene::of_one_material("a shape");
    match random.below(4) {
        0 => {
            let [a, b] = [(); 2].map(|()| at + point(random) * size);
            // up to 10^4 times as long as wide
            let thin = 10.0_f64.powf(unit(random) * -4.0);
            let c = a + (b - a) * unit(random) + point(random) * size * thin;
            scene.push_triangle(material, [a, b, c]);
        }
        1 => scene.push_sphere(material, at, size * (0.3 + unit(random))),
        2 => {
            let cone = Cone {
                base: at + point(random) * size,
                base_radius: unit(random) * size,
                apex: at + point(random) * size,
                apex_radius: unit(random) * size,
            };
            scene.push_cone(material, cone);
        }
        _ => {
            let (u, v) = (point(random) * size, point(random) * size);
            let corners = [at, at + u, at + u + v, at + u * 0.4 + v * 1.1, at + v];
            scene.push_polygon(material, &corners);
        }
    }
    offset_rays(random, rays, &scene, at, size, rule)
}

pub fn from_far_away<S: Buildable>(
    random: &mut Random,
    rays: usize,
    rule: OffsetRule,
) -> RoundResult<S> {
    let size: f64 = one_of(random, &[1e-3, 1.0, 1e3]);
    let away = one_of(random, &[0.0, 1.0, 10.0, 1e2, 1e3, 1e4, 1e5, 1e6]);
    let at = direction(random) * size * away;
    let (mut scene, material) = Scene::of_one_material("far away");
    if random.below(2) == 0 {
        scene.push_sphere(material, at, size);
    } else {
        for [a, b, c] in icosphere(1, DVec3::ZERO) {
            scene.push_triangle(material, [a, b, c].map(|p| at + p * size));
        }
    }
    offset_rays(random, rays, &scene, at, size, rule)
}

/// Rays to the outside of a convex scene about `at`: they meet nothing.
fn offset_rays<S: Buildable>(
    random: &mut Random,
    rays: usize,
    scene: &Scene,
    at: DVec3,
    size: f64,
    rule: OffsetRule,
) -> RoundResult<S> {
    let aimed: Vec<Ray<S>> = (0..rays.div_ceil(A_HIT))
        .map(|_| {
            let from = at + direction(random) * size * 4.0;
            ray(from, at + point(random) * size * 0.5 - from)
        })
        .collect();
    let offset = RayOffset::new(rule, size);
    from_hits(scene, &aimed, |point, incoming, round| {
        let facing = point.refined.normal;
        let outward = if facing.dot(incoming) > 0.0 { -facing } else { facing };
        for turn in 0..A_HIT {
            let any = direction(random);
            let along = if turn % 2 == 0 {
                if any.dot(outward) < 0.0 { -any } else { any }
            } else {
                // grazing, down to an angle of 10^-12
                let graze = 10.0_f64.powf(unit(random) * -12.0);
                (any - outward * any.dot(outward)).normalize_or(outward) + outward * graze
            };
            round.push(offset.along(point, along), OracleAnswer::Miss);
        }
    })
}

/// A plane, another just above it, a light above both: all of the lower one is dark.
pub fn between_planes<S: Buildable>(
    random: &mut Random,
    rays: usize,
    rule: OffsetRule,
) -> RoundResult<S> {
    const GAP: f64 = 1e-3;
    let half: f64 = one_of(random, &[1.0, 10.0, 100.0]);
    let turn = one_of(random, &[0, 1, 2]);
    let turned = |p: DVec3| DVec3::from(turned(p.to_array(), turn));
    let (mut scene, material) = Scene::of_one_material("two planes");
    for (height, reach) in [(0.0, half), (GAP, half * 2.0)] {
        let corner = |x: f64, z: f64| turned(dvec3(x * reach, height, z * reach));
        let [a, b, c, d] = [corner(-1., -1.), corner(1., -1.), corner(1., 1.), corner(-1., 1.)];
        scene.push_triangle(material, [a, b, c]);
        scene.push_triangle(material, [a, c, d]);
    }
    let light = turned(dvec3(0.1, 1.0, -0.2) * half);
    // from within the gap, down to the lower plane
    let aimed: Vec<Ray<S>> = (0..rays)
        .map(|_| {
            let target = dvec3(point(random).x * half, 0.0, point(random).z * half);
            let from = target + dvec3(point(random).x * GAP, GAP * 0.5, point(random).z * GAP);
            ray(turned(from), turned(target - from))
        })
        .collect();
    let offset = RayOffset::new(rule, half * 2.0);
    from_hits(&scene, &aimed, |point, _, round| {
        // only from the lower plane, whichever of the two the rounded ray has met
        if self::turned(point.position.to_array(), 3 - turn)[1].abs() <= GAP * 0.25 {
            let ray = offset.to(point, light);
            round.push(ray, OracleAnswer::Hit { id: None, t: [0.0, ray.t_max.to_f64()] });
        }
    })
}

/// A ball on a plane: whether the ball is in the way of the light follows from its distance to
/// the ray.
pub fn under_a_ball<S: Buildable>(
    random: &mut Random,
    rays: usize,
    rule: OffsetRule,
) -> RoundResult<S> {
    let radius: f64 = one_of(random, &[0.01, 1.0, 100.0]);
    let (mut scene, material) = Scene::of_one_material("a ball on a plane");
    let far = radius * 8.0;
    let [a, b, c] =
        [dvec3(-far, 0.0, -far), dvec3(far * 3.0, 0.0, -far), dvec3(-far, 0.0, far * 3.0)];
    scene.push_triangle(material, [a, b, c]);
    let center = dvec3(0.0, radius, 0.0);
    scene.push_sphere(material, center, radius);
    let light = dvec3(3.0, 9.0, 1.0) * radius;
    // ever closer to where the ball touches
    let aimed: Vec<Ray<S>> = (0..rays)
        .map(|_| {
            let near = 10.0_f64.powf(unit(random) * -5.0) * radius * 2.0;
            let target = direction(random) * near;
            let from = dvec3(target.x * 2.0, -radius, target.z * 2.0);
            // from below: the ball does not hide its own foot
            ray(from, target.with_y(0.0) - from)
        })
        .collect();
    let offset = RayOffset::new(rule, far);
    from_hits(&scene, &aimed, |point, _, round| {
        let ray: Ray<S> = offset.to(point, light);
        let from = point.refined.position;
        let way = (light - from).normalize();
        let to_center = center - from;
        let passing = (to_center - way * to_center.dot(way)).length();
        let clear = S::EPSILON.to_f64() * 64.0 * far;
        round.push(ray, expected_behind(passing, radius, clear, ray.t_max.to_f64()));
    })
}

/// A ray that passes the centre of a ball of `radius` at a distance.
fn expected_behind(passing: f64, radius: f64, clear: f64, t_max: f64) -> OracleAnswer {
    if passing < radius - clear {
        OracleAnswer::Hit { id: Some(1), t: [0.0, t_max] }
    } else if passing > radius + clear {
        OracleAnswer::Miss
    } else {
        OracleAnswer::Anything
    }
}

/// From the floor to a light that stands on the ceiling: the ceiling does not hide it.
pub fn to_a_light_on_a_surface<S: Buildable>(
    random: &mut Random,
    rays: usize,
    rule: OffsetRule,
) -> RoundResult<S> {
    let size: f64 = one_of(random, &[1e-6, 1.0, 1e6]);
    let at = point(random) * size * one_of(random, &[0.0, 1.0, 100.0]);
    let (mut scene, material) = Scene::of_one_material("a light on a ceiling");
    let floor = [(); 3].map(|()| point(random).with_y(0.0) * 2.0);
    // no sliver: where a ray meets one is uncertain by more than the margin at a target
    let ceiling = [dvec3(-1.0, 1.0, -1.0), dvec3(1.2, 1.0, -0.8), dvec3(0.1, 1.0, 1.0)]
        .map(|corner| corner + point(random) * 0.2);
    let [a, b, c] = ceiling;
    let light = at + (a * 0.3 + b * 0.4 + c * 0.3) * size;
    for corners in [floor, ceiling] {
        scene.push_triangle(material, corners.map(|p| at + p * size));
    }
    let aimed: Vec<Ray<S>> = (0..rays)
        .map(|_| {
            let [a, b, c] = floor;
            let (u, v) = (unit(random) * 0.5, unit(random) * 0.5);
            let target = a + (b - a) * u + (c - a) * v;
            let from = target + dvec3(point(random).x, 0.5, point(random).z) * 0.3;
            ray(at + from * size, (target - from) * size)
        })
        .collect();
    let offset = RayOffset::new(rule, size);
    let normal = (b - a).cross(c - a).normalize_or_zero();
    from_hits(&scene, &aimed, |point, _, round| {
        // the ceiling slants: what rounding does grows as a ray grazes it
        let ray: Ray<S> = offset.to(point, light);
        let steep = ray.direction.to_dvec3().dot(normal).abs();
        let expected = if steep > 0.1 { OracleAnswer::Miss } else { OracleAnswer::Anything };
        round.push(ray, expected);
    })
}

/// A round of what `leave` makes of the points that brute force finds with `aimed`, as the renderer
/// sees them, and of the directions that hit them.
pub(super) fn from_hits<S: Buildable>(
    scene: &Scene,
    aimed: &[Ray<S>],
    mut leave: impl FnMut(&SurfacePoint<'_>, DVec3, &mut Round<S>),
) -> RoundResult<S> {
    let mut round = Round::new(Geometry::<S>::of(scene).map_err(|e| e.source)?);
    let surfaces = Surfaces::new(scene, false);
    let mut hits = vec![Hit::NONE; aimed.len()];
    // without brute force there is no hit and so no ray: the case would have no trials
    let _ = with_brute_force(round.model.prims(), |tracer| tracer.closest_hits(aimed, &mut hits));
    for (ray, hit) in aimed.iter().zip(&hits).filter(|(_, hit)| hit.is_hit()) {
        let along = ray.direction.to_dvec3();
        let position = ray.origin.to_dvec3() + along * hit.t.to_f64();
        leave(&surfaces.at(hit.id, position), along, &mut round);
    }
    Ok(round)
}

/// Gaps of fewer ulps may be bridged by the offset of 4 epsilons of the default rule and by what
/// rounding does to a ball's hits beside it.
const NARROW: f64 = 16.0;

/// Nested shells: balls of radius 1 and 1 + k ulps, and rays between them. Rays from outside pass
/// all shells twice each: in chains every surface must be met once, none skipped and none met again.
/// Rays that leave one shell must meet the next one, unless the gap is so narrow that the offset
/// itself bridges it. A fixed distance skips shells.
pub fn shells<S: Buildable>(random: &mut Random, rays: usize, rule: OffsetRule) -> RoundResult<S> {
    const A_HIT: usize = 8;
    let apart = (1.0 + 11.0 * unit(random)).exp2().round();
    let gap = apart * S::EPSILON.to_f64();
    let (mut scene, material) = Scene::of_one_material("shells");
    // the inner one first, and last: ids are no order of radii
    let radii = if random.below(2) == 0 { [1.0, 1.0 + gap] } else { [1.0 + gap, 1.0] };
    radii.iter().for_each(|radius| scene.push_sphere(material, DVec3::ZERO, *radius));
    let inner = radii.iter().position(|r| *r == 1.0).unwrap_or_default() as u32;
    let aimed: Vec<Ray<S>> = (0..rays.div_ceil(2 * A_HIT))
        .map(|_| {
            let origin = single(direction(random) * (2.0 + 2.0 * unit(random)));
            // no closer to the rim than the gap shows on
            ray(origin, direction(random) * 0.8 * unit(random) - origin)
        })
        .collect();
    let within: Vec<Ray<S>> = aimed.iter().map(|r| Ray { t_min: S::ONE, ..*r }).collect();
    let offset = RayOffset::new(rule, 1.0 + gap);
    let is_clear = apart > NARROW;
    // entries from outside, exits from within
    let both: Vec<Ray<S>> = aimed.iter().chain(&within).copied().collect();
    let mut round = from_hits(&scene, &both, |point, _, round| {
        let out = point.refined.normal;
        let is_inner = point.refined.position.length() < 1.0 + gap / 2.0;
        for _ in 0..A_HIT / 2 {
            let any = direction(random);
            let along = (any + out * 1.2).normalize_or_zero();
            let along = if is_inner { along } else { -along };
            let slant = along.dot(out).abs();
            let far = 4.0 * gap / slant + 64.0 * S::EPSILON.to_f64();
            let id = Some(if is_inner { 1 - inner } else { inner });
            let hit = OracleAnswer::Hit { id, t: [0.0, far] };
            let expected = if is_clear { hit } else { OracleAnswer::Anything };
            round.push(offset.along(point, along), expected);
        }
    })?;
    for ray in aimed {
        push_hits(&mut round, ray, A_HIT, |_, hits| broken(hits, is_clear, inner));
    }
    round.truncate(rays);
    Ok(round)
}

/// Describes the error in the hits of a line through both balls, if any.
fn broken<S: Scalar>(hits: &[Hit<S>], is_clear: bool, inner: u32) -> Option<String> {
    for id in [0, 1] {
        let times = hits.iter().filter(|hit| hit.id == id).count();
        if times != 2 {
            return Some(format!("ball {id} is met {times} times"));
        }
    }
    let ids: Vec<u32> = hits.iter().map(|hit| hit.id).collect();
    let outer = 1 - inner;
    let is_nested = ids == [outer, inner, inner, outer];
    (is_clear && !is_nested).then(|| format!("nested balls are met in the order {ids:?}"))
}
