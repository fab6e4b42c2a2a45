//! Intervals of every kind: behind the origin, of one ulp, of one number, begun anew after each hit,
//! and those of far origins.
//!
//! A ray's interval is closed, and nothing forbids that it begins below 0. The hits of the whole
//! line are found by testing each primitive alone; what each interval holds of them follows.
//! Adapters of libraries clamp intervals.

use super::*;
use crate::verify::among_triangles::{exact, reach};
use crate::verify::subject::with_brute_force;
use exact_geometry::triangles::LineCrossing;

/// Links of a chain that are asked.
const LINKS: usize = 40;

pub fn intervals<S: Buildable>(random: &mut Random, rays: usize) -> RoundResult<S> {
    let (model, targets) = scene(random)?;
    Ok(Round::new(model).filled(rays, |round| {
        let target = point_within(random, &targets);
        let (mut origin, along) = toward(random, target, 2.0);
        if random.below(2) == 0 {
            // beyond the target, which then lies behind
            origin = single(target + along * (0.1 + unit(random)));
        }
        let whole = Ray { t_min: S::from_f64(-1e30), ..ray::<S>(origin, along) };
        if !whole.is_traceable() {
            return;
        }
        let hits = every_hit(&round.model, &whole);
        if random.below(3) == 0 {
            let start = one_of(random, &[-1e30, -2.0, 0.0]);
            push_chain(round, Ray { t_min: S::from_f64(start), ..whole }, &hits, LINKS);
        } else {
            let [t_min, t_max] = interval(random, &hits);
            round.push(Ray { t_min, t_max, ..whole }, first_within(&hits, t_min, t_max));
        }
    }))
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
pub(super) fn scene<S: Buildable>(
    random: &mut Random,
) -> Result<(Geometry<S>, Vec<Corners>), PrimitiveError> {
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
            let model = mixed_model(|set| {
                for &triangle in &triangles {
                    set.triangle(triangle)?;
                    set.sphere(point(random), 0.05 + 0.4 * unit(random))?;
                }
                Ok(())
            })?;
            return Ok((model, triangles));
        }
    };
    Ok((model_of(&triangles)?, triangles))
}

/// Epsilons of the distance to the farthest corner by which rounding may move a ray, and of a
/// parameter by which it may be off.
const SHIFT: f64 = 16.0;

/// Origins far from the scene, on either side of it. A structure may move such an origin before it
/// looks at the ray; its answers are about the ray as it was asked. So a hit that is told at `t` is
/// within `[0, t]`, `[t, infinity]` and `[t, t]`.
pub fn far_intervals<S: Buildable>(random: &mut Random, rays: usize) -> RoundResult<S> {
    let (model, triangles) = scene::<S>(random)?;
    let soup = matches!(model, Geometry::Triangles(_)).then(|| Soup::new(&triangles));
    let endless = S::from_f64(1e30);
    let mut round = Round::new(model);
    let lines: Vec<Ray<S>> = (0..rays.div_ceil(4))
        .map(|_| {
            let target = point_within(random, &triangles);
            let along = single(direction(random));
            let away = 10f64.powf(1.0 + 5.0 * unit(random)) * one_of(random, &[1.0, -1.0]);
            let line = ray(single(target + along * away), along);
            Ray { t_min: -endless, t_max: endless, ..line }
        })
        .collect();
    let mut hits = vec![Hit::NONE; lines.len()];
    // without brute force there is no hit: the case would have no trials
    let _ = with_brute_force(round.model.prims(), |t| t.closest_hits(&lines, &mut hits));
    for (line, Hit { t, id }) in lines.iter().zip(hits) {
        let expected = soup.as_ref().and_then(|soup| first_on_line(soup, line));
        round.push(*line, expected.unwrap_or(OracleAnswer::Anything));
        if id == Hit::<S>::NONE.id {
            continue;
        }
        let again = OracleAnswer::Hit { id: None, t: [t.to_f64(); 2] };
        let half = S::from_f64(t.to_f64() / 2.0);
        let [start, end] = [half.lesser(t), half.greater(t)];
        for [t_min, t_max] in [[-endless, t], [t, endless], [t, t], [start, end]] {
            round.push(Ray { t_min, t_max, ..*line }, again.clone());
        }
        round.push(Ray { t_min: t.next_up(), ..*line }, OracleAnswer::Anything);
    }
    round.truncate(rays);
    Ok(round)
}

/// The first hit of the whole line, where it is clear of edges and other triangles.
fn first_on_line<S: Scalar>(soup: &Soup, ray: &Ray<S>) -> Option<OracleAnswer> {
    let epsilon = SHIFT * S::EPSILON.to_f64();
    let shift = epsilon * reach(soup, ray);
    let meetings = exact(ray)?.meetings(soup, 0.0, shift);
    let slack = |m: &LineCrossing| m.blur.t * shift + epsilon * m.t.abs();
    let is_inside = |m: &&LineCrossing| m.depth >= m.blur.depth * shift;
    let Some(first) = meetings.first() else { return Some(OracleAnswer::Miss) };
    let low = meetings.iter().map(|m| m.t - slack(m)).fold(f64::INFINITY, f64::min);
    let ends = meetings.iter().filter(is_inside).map(|m| m.t + slack(m));
    let end = ends.fold(f64::INFINITY, f64::min);
    if end == f64::INFINITY {
        return Some(OracleAnswer::Anything);
    }
    let is_clear = meetings.iter().skip(1).all(|m| m.t - slack(m) > end);
    let id = (is_clear && is_inside(&first)).then_some(first.id);
    Some(OracleAnswer::Hit { id, t: [low, end] })
}
