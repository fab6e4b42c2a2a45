//! Primitives that move while the shutter is open: linear motion, as a time on the ray.
//!
//! Paper: R. Cook, T. Porter, L. Carpenter, "Distributed Ray Tracing", SIGGRAPH 1984: each ray
//! has a time, and primitives are where they are then. Structures see the bounds of the whole
//! way, or of a segment of it, as in A. Glassner, "Spacetime Ray Tracing for Animation", IEEE CG&A 8(2), 1988:
//! see [`crate::structures::time_segments`].
//!
//! The motion is a translation at constant velocity, which serves every kind of primitive: the ray
//! is moved the other way and meets the primitive at rest, in the shear that it has wherever it begins. It is a view of a [`MixedSet`] and not
//! part of its tests, so that sets at rest pay nothing for it.

use glam::DVec3;

use crate::geometry::aabb::Aabb;
use crate::geometry::ray::Ray;
use crate::geometry::scalar::Scalar;
use crate::primitives::{Ball, MixedSet, PrimSet, PrimitiveKind, Shear};

/// A mixed set as rays with a time see it.
#[derive(Debug)]
#[repr(transparent)]
pub struct InMotion<S: Scalar> {
    set: MixedSet<S>,
}

impl<S: Scalar> MixedSet<S> {
    /// The same set as rays with a time see it.
    pub fn in_motion(&self) -> &InMotion<S> {
        // SAFETY: `InMotion` is a transparent wrapper of `MixedSet`.
        unsafe { &*std::ptr::from_ref(self).cast::<InMotion<S>>() }
    }
}

impl<S: Scalar> PrimSet<S> for InMotion<S> {
    /// The shear, and the moment.
    type RaySetup = (Shear<S>, S);

    #[inline(always)]
    fn len(&self) -> usize {
        self.set.len()
    }

    fn bounds(&self, id: u32) -> Aabb<S> {
        self.set.bounds(id)
    }

    fn extent(&self, id: u32, direction: DVec3) -> (f64, f64) {
        self.set.extent(id, direction)
    }

    fn farthest(&self, id: u32, from: DVec3) -> f64 {
        self.set.farthest(id, from)
    }

    fn hull(&self, id: u32, balls: &mut Vec<Ball>) {
        self.set.hull(id, balls);
    }

    fn moves(&self, id: u32) -> bool {
        PrimSet::moves(&self.set, id)
    }

    fn kind(&self, id: u32) -> PrimitiveKind {
        self.set.kind(id)
    }

    #[inline(always)]
    fn setup(&self, ray: &Ray<S>) -> Self::RaySetup {
        (self.set.setup(ray), self.set.motion().moment(ray.time))
    }

    #[inline(always)]
    fn intersect(
        &self,
        id: u32,
        ray: &Ray<S>,
        (shear, moment): &Self::RaySetup,
        t_max: S,
    ) -> Option<S> {
        match self.set.motion().velocity(id) {
            None => self.set.intersect(id, ray, shear, t_max),
            Some(velocity) => {
                let relative = Ray { origin: ray.origin - velocity * *moment, ..*ray };
                let shear = shear.moved_to(relative.origin, self.set.magnitude());
                self.set.intersect(id, &relative, &shear, t_max)
            }
        }
    }

    #[inline(always)]
    fn is_opaque(&self, id: u32) -> bool {
        self.set.is_opaque(id)
    }

    fn magnitude(&self) -> S {
        self.set.magnitude()
    }

    fn bytes(&self) -> usize {
        self.set.bytes()
    }
}
