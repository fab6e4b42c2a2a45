//! Rays that a light buffer answers from its cells.

use super::direction_cube::{CubePoint, place};
use super::margins::Margins;
use crate::geometry::far_ray;
use crate::geometry::ray::Ray;
use crate::geometry::scalar::{Scalar, Vec3, Vector};
use crate::primitives::PrimSet;

/// Rays that cells can answer: those from the scene to the light.
#[derive(Debug, Clone, Copy)]
pub(super) struct LightRays<S> {
    /// Largest distance on an axis from the end of a ray to its light.
    end: S,
    reach: S,
}

impl<S: Scalar> LightRays<S> {
    pub(super) fn new<P: PrimSet<S>>(prims: &P, margins: &Margins) -> Self {
        let reach = far_ray::reach(prims.magnitude());
        Self { end: S::from_f64(margins.end), reach }
    }

    /// Origin of a ray relative to its light; `None` if the ray does not run there.
    #[inline(always)]
    pub(super) fn place(&self, ray: &Ray<S>, light: Vec3<S>) -> Option<CubePoint<S>> {
        let from_light = ray.origin - light;
        let place = place(from_light);
        // NaN fails every one of these
        let is_aimed = is_within::<S>(from_light + ray.direction * ray.t_max, self.end)
            & is_within::<S>(ray.origin, self.reach)
            & (place.depth > self.end * S::from_f64(4.0))
            & (ray.t_min >= S::ZERO);
        is_aimed.then_some(place)
    }
}

/// Returns whether no component is larger than `limit`; false for NaN.
#[inline(always)]
fn is_within<S: Scalar>(v: Vec3<S>, limit: S) -> bool {
    let [x, y, z] = v.to_array();
    (x.abs() <= limit) & (y.abs() <= limit) & (z.abs() <= limit)
}
