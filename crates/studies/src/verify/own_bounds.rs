//! A law that needs no oracle: a triangle is hit where it is.

use accel_core::{Hit, Ray, Scalar, Vector};
use glam::DVec3;

use super::model::Model;

/// Epsilons of the distance to the farthest corner that rounding may add up to.
const ROUNDING: f64 = 16.0;

/// Returns whether a parameter lies before or behind the triangle: outside the slab that holds it
/// on the axis along which the ray runs most. The test's parameter is a mean of its corners',
/// whatever rounding did to their weights, and so never should.
pub fn is_beside_it<S: Scalar>(triangle: &[[S; 3]; 3], ray: &Ray<S>, t: S) -> bool {
    let (o, d) = (ray.origin.to_dvec3(), ray.direction.to_dvec3());
    let corners = triangle.map(|p| DVec3::from_array(p.map(S::to_f64)));
    let axis = d.abs().max_position();
    let slack = rounding::<S>(&corners, o);
    is_outside(&corners.map(|p| p[axis]), o[axis] + d[axis] * t.to_f64(), slack)
}

/// Returns whether the hit point lies outside the box of the triangle by more than rounding
/// explains for a ray at this angle to its plane.
pub fn is_out_of_its_box<S: Scalar>(triangle: &[[S; 3]; 3], ray: &Ray<S>, t: S) -> bool {
    let (o, d) = (ray.origin.to_dvec3(), ray.direction.to_dvec3());
    let corners = triangle.map(|p| DVec3::from_array(p.map(S::to_f64)));
    let [a, b, c] = corners;
    let normal = (b - a).cross(c - a);
    let sine = normal.dot(d).abs() / (normal.length() * d.length());
    let slack = rounding::<S>(&corners, o) * (1.0 + 1.0 / sine);
    let p = o + d * t.to_f64();
    (0..3).any(|k| is_outside(&corners.map(|corner| corner[k]), p[k], slack))
}

/// Epsilons of the largest coordinate by which structures pad boxes: all of them find a hit that
/// lies within.
const PADDING: f64 = 64.0;

/// Says which of these hits lies outside the padded box of its primitive, if one does.
pub fn out_of_padded_box<S: Scalar>(
    model: &Model<S>,
    ray: &Ray<S>,
    hits: &[Hit<S>],
) -> Option<String> {
    let pad = PADDING * S::EPSILON.to_f64() * model.magnitude();
    hits.iter().find_map(|hit| {
        let p = ray.origin.to_dvec3() + ray.direction.to_dvec3() * hit.t.to_f64();
        let bounds = model.bounds(hit.id);
        let (low, high) = (bounds.min.to_dvec3() - pad, bounds.max.to_dvec3() + pad);
        let is_within = low.cmple(p).all() && p.cmple(high).all();
        let told = || format!("primitive {} is hit at {p}, out of its padded box", hit.id);
        (!is_within).then(told)
    })
}

fn rounding<S: Scalar>(corners: &[DVec3; 3], origin: DVec3) -> f64 {
    let reach = corners.iter().map(|p| (*p - origin).abs().max(p.abs()).max_element());
    ROUNDING * S::EPSILON.to_f64() * reach.fold(origin.abs().max_element(), f64::max)
}

fn is_outside(corners: &[f64; 3], x: f64, slack: f64) -> bool {
    let low = corners.iter().copied().fold(f64::INFINITY, f64::min);
    let high = corners.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    // true for NaN too
    let is_within = low - slack <= x && x <= high + slack;
    !is_within
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::verify::round::ray;
    use glam::dvec3;

    #[test]
    fn a_hit_beyond_the_triangle_is_seen_and_one_at_its_edge_is_not() {
        let triangle = [[3.0_f32, 0.0, -1.0], [5.0, 0.0, -1.0], [4.0, 0.0, 2.0]];
        let ray: Ray<f32> = ray(dvec3(0.0, -1e-4, 0.0), dvec3(2.0, 1e-4, 0.0));
        for (t, slab, bounds) in
            [(1.5, false, false), (2.5, false, false), (2.6, true, true), (1.0, true, true)]
        {
            assert_eq!(is_beside_it(&triangle, &ray, t), slab, "{t}");
            assert_eq!(is_out_of_its_box(&triangle, &ray, t), bounds, "{t}");
        }
        assert!(is_beside_it(&triangle, &ray, f32::NAN));
    }
}
