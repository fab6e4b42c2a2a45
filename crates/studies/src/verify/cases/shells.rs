//! Nested shells: balls of radius 1 and 1 + k ulps, and rays between them.
//!
//! Rays from outside pass all shells twice each: in chains every surface must be met once, none
//! skipped and none met again. Rays that leave one shell as the renderer leaves it must meet the
//! next one, unless the gap is so narrow that the offset itself bridges it.

use renderer::ray_offset::{OffsetRule, RayOffset};
use scene_loading::{Material, Scene};

use super::prelude::*;
use super::secondary::from_hits;

/// Rays that leave one hit point.
const A_HIT: usize = 8;

/// Gaps of fewer ulps may be bridged by the offset of 4 epsilons of the default rule and by what
/// rounding does to a ball's hits beside it.
const NARROW: f64 = 16.0;

/// A round under a rule of choice: a fixed distance skips shells.
pub fn shells<S: Buildable>(random: &mut Random, rays: usize, rule: OffsetRule) -> RoundResult<S> {
    let apart = (1.0 + 11.0 * unit(random)).exp2().round();
    let gap = apart * S::EPSILON.to_f64();
    let mut scene = Scene::new("shells");
    let material = scene.push_material(Material::default());
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
        let hits = every_hit(&round.model, &ray);
        match broken(&hits, is_clear, inner) {
            Some(how) => round.push(ray, OracleAnswer::Broken(how)),
            None => push_chain(&mut round, ray, &hits, A_HIT),
        }
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
