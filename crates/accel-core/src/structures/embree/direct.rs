//! Embree as its authors use it: triangles at rest in f32, `rtcIntersect1` and `rtcOccluded1`, nothing of
//! ours but that the answer is written. So its defects are its own as well. Triangles that occlude nothing
//! are a geometry of their own, with a filter that lets all rays pass.

use super::ffi::{self, Context};
use super::scene::Scene;
use crate::geometry::ray::{Hit, MISS, Ray};
use crate::geometry::scalar::{Scalar, Vector};

/// In f32 nothing is converted.
#[inline(always)]
fn own<S: Scalar>(ray: &Ray<S>) -> ffi::Ray {
    let to_f32 = |v: crate::Vec3<S>| v.to_array().map(|x| x.to_f64() as f32);
    ffi::Ray {
        origin: to_f32(ray.origin),
        t_near: ray.t_min.to_f64() as f32,
        direction: to_f32(ray.direction),
        time: 0.0,
        t_far: ray.t_max.to_f64() as f32,
        mask: u32::MAX,
        id: 0,
        flags: 0,
    }
}

#[inline(always)]
pub(super) fn closest_hits<S: Scalar>(scene: &Scene<S>, rays: &[Ray<S>], hits: &mut [Hit<S>]) {
    let mut context = Context::NEW;
    for (ray, hit) in rays.iter().zip(hits) {
        let mut asked = ffi::RayHit { ray: own(ray), hit: ffi::Hit::NONE };
        // SAFETY: the scene is committed; context and ray live until the call returns
        unsafe { ffi::rtcIntersect1(scene.library.scene(), &raw mut context, &raw mut asked) };
        *hit = match scene.id(&asked.hit) {
            Some(id) => Hit { t: S::from_f64(f64::from(asked.ray.t_far)), id },
            None => Hit { t: ray.t_max, id: MISS },
        };
    }
}

#[inline(always)]
pub(super) fn occlusions<S: Scalar>(scene: &Scene<S>, rays: &[Ray<S>], blocked: &mut [bool]) {
    let mut context = Context::NEW;
    for (ray, blocked) in rays.iter().zip(blocked) {
        let mut asked = own(ray);
        // SAFETY: as above
        unsafe { ffi::rtcOccluded1(scene.library.scene(), &raw mut context, &raw mut asked) };
        *blocked = asked.t_far == f32::NEG_INFINITY;
    }
}
