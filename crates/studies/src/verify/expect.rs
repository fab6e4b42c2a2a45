//! Expectations of the exact oracle for the closest hit, as a round states them.

use accel_core::{Ray, Scalar, Vector};

use super::exact::{ExactRay, LineCrossing, Soup};
use super::round::OracleAnswer;

/// How far outside a triangle, in barycentric coordinates, rounding may still find a hit; and how
/// far inside it may still lose one, where no neighbour catches it.
const UNCLEAR: f64 = 1e-3;

/// On a closed mesh, or within a sheet: there is a hit about where the exact one is. Which of the
/// triangles at an edge is hit is left to rounding.
pub fn on_mesh<S: Scalar>(mesh: &Soup, ray: &Ray<S>, slack: f64) -> Option<OracleAnswer> {
    let meetings = ExactRay::new(ray)?.meetings(mesh, 0.0, 0.0);
    let first = meetings.iter().find(|m| m.is_hit() && m.t > 0.0)?;
    Some(OracleAnswer::hit_at(first.t, slack))
}

/// Expectation if all arithmetic of the primitive test is exact (integers, the largest component of
/// the direction a power of two): the lowest id among the nearest, and `t` to an ulp.
pub fn on_lattice<S: Scalar>(triangles: &Soup, ray: &Ray<S>) -> Option<OracleAnswer> {
    let meetings = ExactRay::new(ray)?.meetings(triangles, 0.0, 0.0);
    let mut hits = meetings.iter().filter(|m| m.is_hit() && is_within(ray, m.t));
    let Some(first) = hits.next() else { return Some(OracleAnswer::Miss) };
    let slack = first.t.abs() * S::EPSILON.to_f64();
    let equal = |m: &&LineCrossing| (m.t - first.t).abs() <= 1e-12 * first.t.abs();
    let tied = hits.clone().filter(equal).map(|m| m.id).fold(first.id, u32::min);
    // two parameters that differ, but not in this precision: rounding decides
    let is_clear = hits.filter(|m| !equal(m)).all(|m| m.t - first.t > 4.0 * slack);
    Some(OracleAnswer::Hit { id: is_clear.then_some(tied), t: [first.t - slack, first.t + slack] })
}

/// Epsilons of the distance to the farthest corner by which the rounding of differences to the
/// origin, of shears and of products may move a ray, together.
const SHIFT: f64 = 16.0;

/// Among loose triangles: the hit, where it is clear of all edges and of other triangles in the
/// same place; otherwise whatever brute force says. Where the ray runs nearly in the plane of a
/// triangle, less is clear.
pub fn in_soup<S: Scalar>(triangles: &Soup, ray: &Ray<S>) -> Option<OracleAnswer> {
    let shift = SHIFT * S::EPSILON.to_f64() * triangles.reach(ray.origin.to_dvec3());
    let meetings = ExactRay::new(ray)?.meetings(triangles, UNCLEAR, shift);
    let slack = |m: &LineCrossing| (m.t.abs() * UNCLEAR).max(m.blur.t * shift);
    let mut ahead = meetings.iter().filter(|m| m.t > -UNCLEAR - slack(m));
    let Some(first) = ahead.next() else { return Some(OracleAnswer::Miss) };
    let is_inside = |m: &LineCrossing| m.depth >= UNCLEAR.max(m.blur.depth * shift);
    if !is_inside(first) || first.t < UNCLEAR + slack(first) {
        return Some(OracleAnswer::Anything);
    }
    let twin = |m: &&LineCrossing| m.t == first.t && m.depth == first.depth;
    let end = first.t + slack(first);
    let is_clear = ahead.all(|m| twin(&m) || m.t - slack(m) > end);
    let id = is_clear.then_some(first.id);
    // another one may be first
    let low = meetings.iter().map(|m| m.t - slack(m)).filter(|t| *t > 0.0).fold(end, f64::min);
    Some(OracleAnswer::Hit { id, t: [low.min(first.t - slack(first)), end] })
}

fn is_within<S: Scalar>(ray: &Ray<S>, t: f64) -> bool {
    ray.t_min.to_f64() <= t && t <= ray.t_max.to_f64()
}
