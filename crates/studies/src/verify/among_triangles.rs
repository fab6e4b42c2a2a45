//! What a round may expect of a ray among triangles, from the [crossings](exact_geometry) that are
//! known exactly.

use accel_core::{Ray, Scalar, Vector};
use exact_geometry::triangles::{ExactRay, LineCrossing, Soup};

use super::round::OracleAnswer;

/// The line of a ray; `None` where origin + direction is not exact in f64.
pub fn exact<S: Scalar>(ray: &Ray<S>) -> Option<ExactRay> {
    ExactRay::new(ray.origin.to_dvec3(), ray.direction.to_dvec3())
}

/// The distance from the origin to the farthest corner on any axis; of far origins, to where the
/// product moves them first (`accel_core::geometry::far_ray`).
pub fn reach<S: Scalar>(soup: &Soup, ray: &Ray<S>) -> f64 {
    let (from, [low, high]) = (ray.origin.to_dvec3(), soup.bounds());
    let far = (from - low).abs().max((from - high).abs()).max_element();
    far.min(9.0 * low.abs().max(high.abs()).max_element())
}

/// How far outside a triangle, in barycentric coordinates, rounding may still find a hit; and how
/// far inside it may still lose one, where no neighbour catches it.
const UNCLEAR: f64 = 1e-3;

/// On a closed mesh, or within a sheet: there is a hit about where the exact one is. Which of the
/// triangles at an edge is hit is left to rounding.
pub fn on_mesh<S: Scalar>(mesh: &Soup, ray: &Ray<S>, slack: f64) -> Option<OracleAnswer> {
    let meetings = exact(ray)?.meetings(mesh, 0.0, 0.0);
    let first = meetings.iter().find(|m| m.is_hit() && m.t > 0.0)?;
    Some(OracleAnswer::hit_at(first.t, slack))
}

/// Expectation if all arithmetic of the primitive test is exact (integers, the largest component of
/// the direction a power of two): the lowest id among the nearest, and `t` to an ulp.
pub fn on_lattice<S: Scalar>(triangles: &Soup, ray: &Ray<S>) -> Option<OracleAnswer> {
    let meetings = exact(ray)?.meetings(triangles, 0.0, 0.0);
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
    in_soup_within(S::EPSILON.to_f64(), triangles, ray)
}

/// The same for a ray whose components are off by as much as `epsilon` of the largest one.
pub fn in_soup_within<S: Scalar>(epsilon: f64, soup: &Soup, ray: &Ray<S>) -> Option<OracleAnswer> {
    let shift = SHIFT * epsilon * reach(soup, ray);
    let meetings = exact(ray)?.meetings(soup, UNCLEAR, shift);
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::verify::round::Corners;
    use glam::{DVec3, dvec3};

    #[test]
    fn a_triangle_that_is_nearly_a_line_is_not_judged() {
        // the square of its normal is below f64's numbers; found by `rtbench verify` with 10^6 rays
        let line = [DVec3::ZERO, dvec3(1.0, 1e-318, 0.0), dvec3(2.0, 0.0, 0.0)];
        let behind = [dvec3(-3.0, -3.0, 1.0), dvec3(3.0, -3.0, 1.0), dvec3(0.0, 3.0, 1.0)];
        let ray = Ray::<f64>::new(dvec3(1.0, 0.0, -1.0), dvec3(0.0, 0.0, 1.0));
        let answer = |triangles: &[Corners]| in_soup(&Soup::new(triangles), &ray);
        assert_eq!(answer(&[line, behind]), Some(OracleAnswer::Anything));
        assert!(matches!(answer(&[behind]), Some(OracleAnswer::Hit { id: Some(0), .. })));
    }
}
