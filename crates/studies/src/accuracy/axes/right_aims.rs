//! Rays whose answers are known for certain: what the steps of `right-answers` are judged by.
//!
//! * At corners and edges within a mesh, one of the triangles around the target must be hit
//!   ([`super::triangle_aims`]).
//! * Along an axis, its other components -0, or from close by, at the middle of a triangle: by
//!   exact predicates the ray meets it, so that something must be hit no later.
//!
//! An answer is wrong where nothing is hit, or only what lies clearly behind.

use accel_core::primitives::{PrimSet, PrimsRef};
use accel_core::query::tracer::Tracer;
use accel_core::registry::Buildable;
use accel_core::{Hit, Ray, Scalar};
use glam::DVec3;

use super::triangle_aims::SharedFeatures;
use crate::accuracy::stage::Stage;
use crate::verify::draw::unit;
use crate::verify::exact::{ExactRay, Soup};

/// A hit by so much later than the target, of the target's parameter, lies behind it.
const BEHIND: f64 = 1e-3;
/// A target must be so deep within its triangle, in barycentric coordinates.
const DEEP: f64 = 0.01;
/// A ray begins so many epsilons of the largest coordinate before its target, at least: nearer, its
/// own rounding decides on which side.
const NEAREST: f64 = 512.0;

/// A ray, and the parameter by which it must have hit something.
#[derive(Debug, Clone, Copy)]
pub struct KnownHit {
    pub ray: Ray<f32>,
    /// A later hit lies behind what is there.
    pub latest: f64,
}

impl KnownHit {
    /// Returns whether an answer cannot be right.
    pub fn is_wrong<S: Scalar>(&self, hit: &Hit<S>) -> bool {
        !hit.is_hit() || hit.t.to_f64() > self.latest
    }
}

/// Number of wrong answers to such rays.
pub fn wrong<S: Buildable>(tracer: &dyn Tracer<S>, known: &[KnownHit], rays: &[Ray<S>]) -> u64 {
    let mut hits = vec![Hit::NONE; rays.len()];
    tracer.closest_hits(rays, &mut hits);
    known.iter().zip(&hits).filter(|(known, hit)| known.is_wrong(hit)).count() as u64
}

/// The triangles of the scene with their ids.
fn triangles(prims: PrimsRef<'_, f32>) -> Vec<(u32, [[f32; 3]; 3])> {
    fn of<P: PrimSet<f32>>(set: &P) -> Vec<(u32, [[f32; 3]; 3])> {
        let corners = |id| Some((id, set.corners(id)?.map(|p| p.to_array())));
        (0..set.len() as u32).filter_map(corners).collect()
    }
    match prims {
        PrimsRef::Watertight(set) => of(set),
        PrimsRef::Mixed(set) => of(set),
    }
}

/// Rays at corners and edges, and rays along axes and from close by; `most` of each at most.
pub fn known_hits(stage: &Stage<'_>, most: usize) -> [Vec<KnownHit>; 2] {
    let triangles = triangles(stage.prepared.geometry.prims());
    let corners = || triangles.iter().flat_map(|(_, t)| t).map(|p| glam::Vec3::from(*p));
    let low = corners().fold(glam::Vec3::INFINITY, glam::Vec3::min);
    let high = corners().fold(glam::Vec3::NEG_INFINITY, glam::Vec3::max);
    let (centre, reach) = ((low + high) * 0.5, (high - low).length());
    let shared = SharedFeatures::new(&triangles);
    let mut random = stage.random("edges");
    let drawn = (0..most * 8).filter_map(|_| shared.aim(&mut random, centre, reach));
    // the direction goes from the origin to the target
    let at_edges = drawn.map(|aim| KnownHit { ray: aim.ray, latest: 1.0 + BEHIND }).take(most);
    let at_edges = at_edges.collect();
    let magnitude = f64::from(low.abs().max(high.abs()).max_element());
    let nearest = NEAREST * f64::from(f32::EPSILON) * magnitude;
    let mut random = stage.random("middles");
    let drawn = (0..most * 4).filter_map(|_| {
        let (_, t) = triangles.get(random.below(triangles.len()))?;
        let t = t.map(|p| glam::Vec3::from(p).as_dvec3());
        let normal = (t[1] - t[0]).cross(t[2] - t[0]);
        let k = (0..3).max_by(|&a, &b| normal[a].abs().total_cmp(&normal[b].abs()))?;
        let sign = if random.below(2) == 0 { 1.0 } else { -1.0 };
        let away = nearest * (f64::from(reach) / nearest).max(2.0).powf(unit(&mut random));
        middle(t, k, sign, away, nearest)
    });
    [at_edges, drawn.take(most).collect()]
}

/// A ray along axis `k` at the middle of a triangle, from that far away.
fn middle(t: [DVec3; 3], k: usize, sign: f64, away: f64, nearest: f64) -> Option<KnownHit> {
    let mut from = (t[0] + t[1] + t[2]) / 3.0;
    from[k] += sign * away;
    let mut direction = glam::Vec3::splat(-0.0);
    direction[k] = -sign as f32;
    let ray = Ray::<f32>::new(from.as_vec3(), direction);
    let met = ExactRay::new(&ray)?.meetings(&Soup::new(&[t]), 0.0, 0.0);
    let met = met.first().filter(|met| met.depth > DEEP && met.t > nearest)?;
    let latest = met.t * (1.0 + BEHIND) + nearest;
    ray.is_traceable().then_some(KnownHit { ray, latest })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rays_at_triangle_centres_must_hit() {
        let t = [DVec3::ZERO, glam::dvec3(1.0, 0.0, 0.0), glam::dvec3(0.0, 1.0, 0.0)];
        let known = middle(t, 2, 1.0, 0.5, 1e-4).unwrap();
        assert!(known.ray.direction.x.is_sign_negative() && known.ray.direction.x == 0.0);
        assert!(!known.is_wrong(&Hit { t: 0.5_f32, id: 0 }));
        assert!(!known.is_wrong(&Hit { t: 0.2_f32, id: 7 }), "something may stand in front");
        assert!(known.is_wrong(&Hit { t: 0.51_f32, id: 7 }) && known.is_wrong(&Hit::<f32>::NONE));
        // too near to tell, or in the plane of the ray
        assert!(middle(t, 2, 1.0, 1e-5, 1e-4).is_none());
        assert!(middle(t, 0, 1.0, 0.5, 1e-4).is_none());
    }
}
