//! A mixed set whose triangles and spheres have other tests, compiled as the default tests are into
//! the traversals of the structures that offer them.
//!
//! It is a view without a cost of its own: with the default tests it computes what a [`MixedSet`]
//! does. Polygons and cones keep their tests, so that the shear of a ray is computed for the
//! polygons whatever the test of triangles is. Primitives that move are seen where they are at time
//! 0.

use std::marker::PhantomData;

use glam::DVec3;

use crate::geometry::aabb::Aabb;
use crate::geometry::ray::Ray;
use crate::geometry::scalar::{Scalar, Vec3};
use crate::primitives::prim_set::as_its_set;
use crate::primitives::{Ball, MixedSet, PrimSet, PrimitiveKind, Shear, SphereTest, TriangleTest};

/// A mixed set, its triangles tested by `T`, its spheres by `Q`.
#[derive(Debug)]
#[repr(transparent)]
pub struct RetestedSet<S: Scalar, T, Q> {
    set: MixedSet<S>,
    tests: PhantomData<(T, Q)>,
}

impl<S: Scalar> MixedSet<S> {
    /// The same set under other tests; nothing is copied.
    pub fn retested<T: TriangleTest<S>, Q: SphereTest<S>>(&self) -> &RetestedSet<S, T, Q> {
        // SAFETY: `RetestedSet` is a transparent wrapper of `MixedSet`.
        unsafe { &*std::ptr::from_ref(self).cast::<RetestedSet<S, T, Q>>() }
    }
}

impl<S: Scalar, T: TriangleTest<S>, Q: SphereTest<S>> PrimSet<S> for RetestedSet<S, T, Q> {
    type RaySetup = (Shear<S>, T::Setup);
    const HAS_OTHER_TESTS: bool = true;

    as_its_set!(S);

    fn corners(&self, id: u32) -> Option<[Vec3<S>; 3]> {
        self.set.corners(id)
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
}
