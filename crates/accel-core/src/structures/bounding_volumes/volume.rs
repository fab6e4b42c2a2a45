//! The interface of bounding volumes, and boxes as the simplest kind.

use crate::geometry::aabb::Aabb;
use crate::geometry::box_test::BoxTest;
use crate::geometry::ray::Ray;
use crate::geometry::scalar::{Scalar, Vec3};
use crate::historical::bounds_rule::BoundsOf;
use crate::params::{ParamSpec, Params};

/// A closed volume around primitives.
pub(crate) trait Volume<S: Scalar>: Copy + Send + Sync {
    /// Data of a ray that the test needs, computed once per ray.
    type RaySetup;

    /// The volume around the primitives, padded so that no rounding, of the test or of a hit point,
    /// loses a hit. The boxes are [`crate::historical::bounds_rule::BoundsRule::Padded`] ones.
    fn around(ids: &[u32], boxes: &BoundsOf<S>) -> Self;

    fn setup(ray: &Ray<S>) -> Self::RaySetup;

    /// The first parameter in `[t_min, t_max]` at which the ray is within the volume, or a smaller
    /// one by the padding; `None` when it is nowhere.
    fn entry(&self, ray: &Self::RaySetup, t_min: S, t_max: S) -> Option<S>;

    /// A box around it.
    fn bounds(&self) -> Aabb<f64>;
}

/// The smallest box around the padded boxes of the primitives.
pub(super) fn box_around<S: Scalar>(ids: &[u32], boxes: &BoundsOf<S>) -> Aabb<S> {
    ids.iter().fold(Aabb::empty(), |all, &id| all.union(boxes.of(id)))
}

impl<S: Scalar> Volume<S> for Aabb<S> {
    type RaySetup = (Vec3<S>, Vec3<S>);

    fn around(ids: &[u32], boxes: &BoundsOf<S>) -> Self {
        box_around(ids, boxes)
    }

    #[inline(always)]
    fn setup(ray: &Ray<S>) -> Self::RaySetup {
        (ray.origin, ray.direction)
    }

    #[inline(always)]
    fn entry(&self, ray: &Self::RaySetup, t_min: S, t_max: S) -> Option<S> {
        self.clip(ray.0, ray.1, t_min, t_max).map(|(t_in, _)| t_in)
    }

    fn bounds(&self) -> Aabb<f64> {
        self.in_double()
    }
}

/// How boxes are tested.
pub(super) const BOX_TEST: ParamSpec =
    ParamSpec::choice("box-test", "default", &["default", "plain", "padded", "f64"]).about(
        "test of volume=box: the default has padded boxes; for comparison, on tight ones: the \
              plain slab test, exits two ulps later, the same in f64",
    );

/// The test for comparison that the settings ask for, if any.
pub(super) fn box_test(params: &Params) -> Option<BoxTest> {
    match params.text(BOX_TEST.name) {
        "plain" => Some(BoxTest::Plain),
        "padded" => Some(BoxTest::Padded),
        "f64" => Some(BoxTest::Double),
        _ => None,
    }
}

/// A tight box, tested by a [`BoxTest`] that comes with the ray.
#[derive(Debug, Clone, Copy)]
pub(super) struct ComparedBox<S: Scalar>(Aabb<S>);

impl<S: Scalar> Volume<S> for ComparedBox<S> {
    type RaySetup = (BoxTest, Ray<S>);

    fn around(ids: &[u32], boxes: &BoundsOf<S>) -> Self {
        let tight = ids.iter().map(|&id| boxes.prims().bounds(id));
        Self(tight.fold(Aabb::empty(), Aabb::union))
    }

    #[inline(always)]
    fn setup(ray: &Ray<S>) -> Self::RaySetup {
        (BoxTest::Padded, *ray)
    }

    #[inline(always)]
    fn entry(&self, (test, ray): &Self::RaySetup, t_min: S, t_max: S) -> Option<S> {
        test.entry(&self.0, ray, t_min, t_max)
    }

    fn bounds(&self) -> Aabb<f64> {
        self.0.in_double()
    }
}
