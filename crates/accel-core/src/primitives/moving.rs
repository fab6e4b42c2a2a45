//! Primitives that move while the shutter is open: linear motion, as a time on the ray.
//!
//! Paper: R. Cook, T. Porter, L. Carpenter, "Distributed Ray Tracing", SIGGRAPH 1984: each ray
//! has a time, and primitives are where they are then. Structures see the bounds of the whole
//! way, as in A. Glassner, "Spacetime Ray Tracing for Animation", IEEE CG&A 8(2), 1988, whose
//! subdivision of time we leave out.
//!
//! The motion is a translation at constant velocity, which serves every kind of primitive: the ray
//! is moved the other way and meets the primitive at rest. It is a view of a [`MixedSet`] and not
//! part of its tests, so that sets at rest pay nothing for it.

use glam::DVec3;

use super::{Ball, MixedSet, PrimSet, PrimitiveKind};
use crate::aabb::Aabb;
use crate::ray::Ray;
use crate::scalar::{Scalar, Vec3, Vector};

/// How the primitives of a set move.
#[derive(Debug, Clone)]
pub(super) struct Motion<S: Scalar> {
    /// World units a unit of time, by id; those beyond the end are at rest.
    velocities: Vec<[S; 3]>,
    /// They move from time 0 to this one.
    exposure: S,
}

impl<S: Scalar> Default for Motion<S> {
    fn default() -> Self {
        Self { velocities: Vec::new(), exposure: S::ZERO }
    }
}

impl<S: Scalar> Motion<S> {
    /// Lets a primitive move.
    pub fn set(&mut self, id: u32, velocity: DVec3, exposure: f64) {
        let index = id as usize;
        if self.velocities.len() <= index {
            self.velocities.resize(index + 1, [S::ZERO; 3]);
        }
        self.velocities[index] = Vec3::<S>::from_dvec3(velocity).to_array();
        self.exposure = S::from_f64(exposure);
    }

    /// Whether anything moves.
    pub fn any(&self) -> bool {
        !self.velocities.is_empty()
    }

    /// Its velocity, if it moves.
    #[inline(always)]
    pub(super) fn velocity(&self, id: u32) -> Option<Vec3<S>> {
        let v = *self.velocities.get(id as usize)?;
        (v != [S::ZERO; 3]).then(|| Vec3::<S>::from_array(v))
    }

    /// From where a primitive starts to where it ends.
    pub fn way(&self, id: u32) -> DVec3 {
        self.velocity(id).map_or(DVec3::ZERO, |v| (v * self.exposure).to_dvec3())
    }

    /// Bounds of the whole way, from those at time 0. Rounding is left to the padding of boxes.
    pub fn swept(&self, id: u32, still: Aabb<S>) -> Aabb<S> {
        let Some(velocity) = self.velocity(id) else { return still };
        let way = velocity * self.exposure;
        if !way.is_finite() {
            return Aabb { min: way, max: way };
        }
        still.union(Aabb { min: still.min + way, max: still.max + way })
    }

    /// Extent of the whole way along `direction`, from that at time 0.
    pub fn swept_extent(&self, id: u32, still: (f64, f64), direction: DVec3) -> (f64, f64) {
        let along = self.way(id).dot(direction);
        (still.0.min(still.0 + along), still.1.max(still.1 + along))
    }

    /// Bytes of the velocities.
    pub fn bytes(&self) -> usize {
        size_of_val(self.velocities.as_slice())
    }
}

/// A mixed set as rays with a time see it.
#[derive(Debug)]
#[repr(transparent)]
pub struct InMotion<S: Scalar> {
    set: MixedSet<S>,
}

impl<S: Scalar> InMotion<S> {
    pub(super) fn of(set: &MixedSet<S>) -> &Self {
        // SAFETY: `InMotion` is a transparent wrapper of `MixedSet`.
        unsafe { &*std::ptr::from_ref(set).cast::<Self>() }
    }
}

impl<S: Scalar> PrimSet<S> for InMotion<S> {
    type RaySetup = <MixedSet<S> as PrimSet<S>>::RaySetup;

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
        self.set.setup(ray)
    }

    #[inline(always)]
    fn intersect(&self, id: u32, ray: &Ray<S>, setup: &Self::RaySetup, t_max: S) -> Option<S> {
        match self.set.motion().velocity(id) {
            None => self.set.intersect(id, ray, setup, t_max),
            Some(velocity) => {
                let relative = Ray { origin: ray.origin - velocity * ray.time, ..*ray };
                self.set.intersect(id, &relative, &self.set.setup(&relative), t_max)
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
