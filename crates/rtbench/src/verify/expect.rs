//! What the exact oracle expects of the closest hit, in the words of a round.

use accel_core::{Ray, Scalar};

use super::exact::{ExactRay, Meeting, Soup};
use super::round::Expected;

/// How far outside a triangle, in barycentric coordinates, rounding may still find a hit; and how
/// far inside it may still lose one, where no neighbour catches it.
const UNCLEAR: f64 = 1e-3;

/// On a closed mesh, or within a sheet: there is a hit about where the exact one is. Which of the
/// triangles at an edge is hit is left to rounding.
pub fn on_mesh<S: Scalar>(mesh: &Soup, ray: &Ray<S>, slack: f64) -> Option<Expected> {
    let meetings = ExactRay::new(ray)?.meetings(mesh, 0.0);
    let first = meetings.iter().find(|m| m.is_hit() && m.t > 0.0)?;
    Some(Expected::hit_at(first.t, slack))
}

/// Where all arithmetic of the primitive test is exact (whole numbers, the largest component of
/// the direction a power of two): the lowest id among the nearest, and `t` to an ulp.
pub fn on_lattice<S: Scalar>(triangles: &Soup, ray: &Ray<S>) -> Option<Expected> {
    let meetings = ExactRay::new(ray)?.meetings(triangles, 0.0);
    let mut hits = meetings.iter().filter(|m| m.is_hit() && is_within(ray, m.t));
    let Some(first) = hits.next() else { return Some(Expected::Miss) };
    let slack = first.t.abs() * S::EPSILON.to_f64();
    let equal = |m: &&Meeting| (m.t - first.t).abs() <= 1e-12 * first.t.abs();
    let tied = hits.clone().filter(equal).map(|m| m.id).fold(first.id, u32::min);
    // two parameters that differ, but not in this precision: rounding decides
    let is_clear = hits.filter(|m| !equal(m)).all(|m| m.t - first.t > 4.0 * slack);
    Some(Expected::Hit { id: is_clear.then_some(tied), t: [first.t - slack, first.t + slack] })
}

/// Among loose triangles: the hit, where it is clear of all edges and of other triangles in the
/// same place; otherwise whatever brute force says.
pub fn in_soup<S: Scalar>(triangles: &Soup, ray: &Ray<S>) -> Option<Expected> {
    let meetings = ExactRay::new(ray)?.meetings(triangles, UNCLEAR);
    let mut ahead = meetings.iter().filter(|m| m.t > -UNCLEAR);
    let Some(first) = ahead.next() else { return Some(Expected::Miss) };
    if first.depth < UNCLEAR || first.t < UNCLEAR {
        return Some(Expected::Anything);
    }
    let slack = first.t * UNCLEAR;
    let twin = |m: &&Meeting| m.t == first.t && m.depth == first.depth;
    let is_clear = ahead.all(|m| twin(&m) || m.t - first.t > slack);
    let id = is_clear.then_some(first.id);
    Some(Expected::Hit { id, t: [first.t - slack, first.t + slack] })
}

fn is_within<S: Scalar>(ray: &Ray<S>, t: f64) -> bool {
    ray.t_min.to_f64() <= t && t <= ray.t_max.to_f64()
}
