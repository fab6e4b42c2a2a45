//! A mixed set whose triangles and spheres have other tests, compiled into each traversal as the
//! default tests are.
//!
//! It is a view without a cost of its own: with the default tests it computes what a [`MixedSet`]
//! does. Polygons and cones keep their tests, so that the shear of a ray is computed for the polygons
//! whatever the test of triangles is. Primitives that move are seen where they are at time 0.

use std::marker::PhantomData;

use glam::DVec3;

use crate::geometry::aabb::Aabb;
use crate::geometry::ray::Ray;
use crate::geometry::scalar::{Scalar, Vec3};
use crate::primitives::{Ball, MixedSet, PrimSet, PrimitiveKind, Shear, SphereTest, TriangleTest};

/// A mixed set, its triangles tested by `T`, its spheres by `Q`.
#[derive(Debug)]
#[repr(transparent)]
pub struct Retested<S: Scalar, T, Q> {
    set: MixedSet<S>,
    tests: PhantomData<(T, Q)>,
}

impl<S: Scalar> MixedSet<S> {
    /// The same set under other tests; nothing is copied.
    pub fn retested<T: TriangleTest<S>, Q: SphereTest<S>>(&self) -> &Retested<S, T, Q> {
        // SAFETY: `Retested` is a transparent wrapper of `MixedSet`.
        unsafe { &*std::ptr::from_ref(self).cast::<Retested<S, T, Q>>() }
    }
}

impl<S: Scalar, T: TriangleTest<S>, Q: SphereTest<S>> PrimSet<S> for Retested<S, T, Q> {
    type RaySetup = (Shear<S>, T::Setup);

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

    fn corners(&self, id: u32) -> Option<[Vec3<S>; 3]> {
        self.set.corners(id)
    }

    fn moves(&self, id: u32) -> bool {
        PrimSet::moves(&self.set, id)
    }

    fn kind(&self, id: u32) -> PrimitiveKind {
        self.set.kind(id)
    }

    #[inline(always)]
    fn setup(&self, ray: &Ray<S>) -> Self::RaySetup {
        let shear = self.set.setup(ray);
        (shear, T::setup_beside(ray, self.set.magnitude(), &shear))
    }

    #[inline(always)]
    fn intersect(&self, id: u32, ray: &Ray<S>, setup: &Self::RaySetup, t_max: S) -> Option<S> {
        self.set.tested::<T, Q>(id, ray, &setup.0, &setup.1, t_max)
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
