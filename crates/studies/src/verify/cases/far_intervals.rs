//! Origins far from the scene, on either side of it, and intervals that begin below 0 or end at a
//! hit.
//!
//! A structure may move such an origin before it looks at the ray; its answers are about the ray as
//! it was asked. So a hit that is told at `t` is within `[0, t]`, `[t, infinity]` and `[t, t]`.

use accel_core::primitives::PrimitiveError;
use accel_core::registry::Buildable;
use accel_core::{Hit, Ray, Scalar, Vector};

use super::intervals::scene;
use super::point_within;
use crate::case;
use crate::verify::draw::{direction, one_of, single, unit};
use crate::verify::exact::{ExactRay, LineCrossing, Soup};
use crate::verify::model::Model;
use crate::verify::registry::Case;
use crate::verify::round::{OracleAnswer, Round, ray};
use crate::verify::subject::with_brute_force;
use statistics::random::Random;

pub const Q4: Case = case!(
    "Q4",
    "exact, the told parameter asked again",
    far_intervals,
    "far origins: t_min below 0, t_max finite, and intervals that begin or end at the hit"
);

/// Epsilons of the distance to the farthest corner by which rounding may move a ray, and of a
/// parameter by which it may be off.
const SHIFT: f64 = 16.0;

fn far_intervals<S: Buildable>(
    random: &mut Random,
    rays: usize,
) -> Result<Round<S>, PrimitiveError> {
    let (model, triangles) = scene::<S>(random)?;
    let soup = matches!(model, Model::Triangles(_)).then(|| Soup::new(&triangles));
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
    round.rays.truncate(rays);
    round.expected.truncate(rays);
    Ok(round)
}

/// The first hit of the whole line, where it is clear of edges and other triangles.
fn first_on_line<S: Scalar>(soup: &Soup, ray: &Ray<S>) -> Option<OracleAnswer> {
    let epsilon = SHIFT * S::EPSILON.to_f64();
    let shift = epsilon * soup.reach(ray.origin.to_dvec3());
    let meetings = ExactRay::new(ray)?.meetings(soup, 0.0, shift);
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
