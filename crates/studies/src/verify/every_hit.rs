//! Every hit of a ray, found without a structure: each primitive is tested alone. And a law that
//! needs no oracle: a primitive is hit where it is.

use std::cmp::Ordering;

use accel_core::primitives::PrimSet;
use accel_core::registry::Buildable;
use accel_core::{Hit, Ray, Scalar, Vector};
use glam::DVec3;
use renderer::Geometry;

use super::round::{OracleAnswer, Round, magnitude};

/// A line meets a convex surface twice; more hits of one primitive are a fault, and enough of one.
const MOST_OF_ONE: usize = 8;

/// All hits within the ray's interval, by parameter and id.
pub fn every_hit<S: Buildable>(model: &Geometry<S>, ray: &Ray<S>) -> Vec<Hit<S>> {
    hits_among(model, ray, 0..model.len() as u32)
}

/// All hits of the primitives of these ids, likewise.
pub fn hits_among<S: Buildable>(
    model: &Geometry<S>,
    ray: &Ray<S>,
    ids: impl IntoIterator<Item = u32>,
) -> Vec<Hit<S>> {
    match model {
        Geometry::Triangles(set) => hits_of(set, ray, ids),
        Geometry::Mixed(set) => hits_of(set, ray, ids),
    }
}

fn hits_of<S: Scalar>(
    prims: &impl PrimSet<S>,
    ray: &Ray<S>,
    ids: impl IntoIterator<Item = u32>,
) -> Vec<Hit<S>> {
    let setup = prims.setup(ray);
    let mut all = Vec::new();
    for id in ids {
        let mut ahead = *ray;
        for _ in 0..MOST_OF_ONE {
            let Some(t) = prims.intersect(id, &ahead, &setup, ray.t_max) else { break };
            all.push(Hit { t, id });
            ahead.t_min = t.next_up();
        }
    }
    all.sort_by(order);
    all
}

/// By parameter, zeros of both signs being equal, then by id.
fn order<S: Scalar>(a: &Hit<S>, b: &Hit<S>) -> Ordering {
    a.t.partial_cmp(&b.t).unwrap_or(Ordering::Equal).then(a.id.cmp(&b.id))
}

/// Closest hit in `[t_min, t_max]`, bit by bit, among these sorted hits: the first, and so the
/// lowest id of equal ones.
pub fn first_within<S: Scalar>(hits: &[Hit<S>], t_min: S, t_max: S) -> OracleAnswer {
    let first = hits.iter().find(|hit| t_min <= hit.t && hit.t <= t_max);
    first.map_or(OracleAnswer::Miss, |hit| OracleAnswer::Hit {
        id: Some(hit.id),
        t: [hit.t.to_f64(); 2],
    })
}

/// Adds the ray, and again with its interval begun just after each of its hits (`hits`, sorted):
/// every hit must be found once and in order, of equal ones that of the lowest id; then nothing.
/// A structure that answers each link so answers the chain so. No more than `most` links.
pub fn push_chain<S: Buildable>(round: &mut Round<S>, ray: Ray<S>, hits: &[Hit<S>], most: usize) {
    let mut link = ray;
    for _ in 0..most {
        round.push(link, first_within(hits, link.t_min, link.t_max));
        let Some(hit) = hits.iter().find(|hit| link.t_min <= hit.t) else { return };
        link.t_min = hit.t.next_up();
    }
}

/// Adds a ray that can be traced, with the chain of all its hits, or with the fault of them that
/// `fault` finds.
pub fn push_hits<S: Buildable>(
    round: &mut Round<S>,
    ray: Ray<S>,
    most: usize,
    fault: impl FnOnce(&Geometry<S>, &[Hit<S>]) -> Option<String>,
) {
    if !ray.is_traceable() {
        return;
    }
    let hits = every_hit(&round.model, &ray);
    match fault(&round.model, &hits) {
        Some(fault) => round.push(ray, OracleAnswer::Broken(fault)),
        None => push_chain(round, ray, &hits, most),
    }
}

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
pub fn outside_box<S: Buildable>(
    model: &Geometry<S>,
    ray: &Ray<S>,
    hits: &[Hit<S>],
) -> Option<String> {
    let pad = PADDING * S::EPSILON.to_f64() * magnitude(model);
    hits.iter().find_map(|hit| {
        let p = ray.origin.to_dvec3() + ray.direction.to_dvec3() * hit.t.to_f64();
        let bounds = model.prims().primitives().bounds(hit.id);
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
    use crate::verify::round::{mixed_model, ray};
    use glam::dvec3;

    #[test]
    fn both_sides_of_a_ball_and_both_of_equal_triangles() {
        let corners = [DVec3::ZERO, DVec3::X * 4.0, DVec3::Y * 4.0];
        let model = mixed_model::<f32>(|set| {
            set.sphere(dvec3(1.0, 1.0, 0.0), 0.5)?;
            set.triangle(corners)?;
            set.triangle(corners)
        })
        .unwrap();
        let mut line: Ray<f32> = ray(dvec3(1.0, 1.0, 0.25), -DVec3::Z);
        line.t_min = f32::NEG_INFINITY;
        let hits = every_hit(&model, &line);
        let told: Vec<(f32, u32)> = hits.iter().map(|h| (h.t, h.id)).collect();
        assert_eq!(told, [(-0.25, 0), (0.25, 1), (0.25, 2), (0.75, 0)]);
        let mut round = Round::new(model);
        push_chain(&mut round, line, &hits, 9);
        let hit = |t, id| OracleAnswer::Hit { id: Some(id), t: [t, t] };
        assert_eq!(round.expected, [hit(-0.25, 0), hit(0.25, 1), hit(0.75, 0), OracleAnswer::Miss]);
        assert_eq!(round.rays[2].t_min, 0.25_f32.next_up());
    }

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
