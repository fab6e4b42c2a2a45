//! Primitives that move while the shutter is open: linear motion, as a time on the ray.
//!
//! Paper: R. Cook, T. Porter, L. Carpenter, "Distributed Ray Tracing", SIGGRAPH 1984: each ray
//! has a time, and primitives are where they are then. Structures see the bounds of the whole
//! way, as in A. Glassner, "Spacetime Ray Tracing for Animation", IEEE CG&A 8(2), 1988, whose
//! subdivision of time we leave out.
//!
//! The motion is a translation at constant velocity, which serves every kind of primitive: the ray
//! is moved the other way and meets the primitive at rest.

use glam::DVec3;

use super::PrimitiveKind;
use crate::aabb::Aabb;
use crate::ray::Ray;
use crate::scalar::{Scalar, Vec3, Vector};

/// A primitive of a mixed set that moves.
#[derive(Debug, Clone, Copy)]
pub(super) struct Moving<S: Scalar> {
    /// Where its shape is kept: the kind and the index within it.
    pub shape: (PrimitiveKind, usize),
    /// World units a unit of time.
    pub velocity: Vec3<S>,
    /// It moves from time 0 to this one.
    pub exposure: S,
}

impl<S: Scalar> Moving<S> {
    /// The ray as the primitive at rest sees it.
    #[inline(always)]
    pub fn relative(&self, ray: &Ray<S>) -> Ray<S> {
        Ray { origin: ray.origin - self.velocity * ray.time, ..*ray }
    }

    /// From where it starts to where it ends.
    pub fn way(&self) -> DVec3 {
        (self.velocity * self.exposure).to_dvec3()
    }

    /// Bounds of the whole way, from those at time 0. Rounding is left to the padding of boxes.
    pub fn swept(&self, still: Aabb<S>) -> Aabb<S> {
        let way = self.velocity * self.exposure;
        still.union(Aabb { min: still.min + way, max: still.max + way })
    }

    /// Extent of the whole way along `direction`, from that at time 0.
    pub fn swept_extent(&self, still: (f64, f64), direction: DVec3) -> (f64, f64) {
        let along = self.way().dot(direction);
        (still.0.min(still.0 + along), still.1.max(still.1 + along))
    }
}
