//! The scene of a round, triangles alone or primitives of any kind, and its rays.

use accel_core::primitives::{
    MixedSet, MixedSetBuilder, PrimitiveError, Primitives, PrimsRef, TriangleSet,
};
use accel_core::{Aabb, Ray, Scalar, Vector};
use glam::DVec3;

pub type Corners = [DVec3; 3];

/// A set of primitives of either kind.
#[derive(Debug)]
pub enum Model<S: Scalar> {
    /// Triangles with the watertight test.
    Triangles(TriangleSet<S>),
    /// Primitives of any kind.
    Mixed(MixedSet<S>),
}

impl<S: Scalar> Model<S> {
    /// Triangles; the coordinates are rounded to `S`.
    pub fn triangles(corners: &[Corners]) -> Result<Self, PrimitiveError> {
        let rounded = corners.iter().map(|t| t.map(|p| p.to_array().map(S::from_f64))).collect();
        Ok(Self::Triangles(TriangleSet::new(rounded, |_| false)?))
    }

    /// Model of the primitives that `add` puts into a builder.
    pub fn mixed(
        add: impl FnOnce(&mut MixedSetBuilder<S>) -> Result<(), PrimitiveError>,
    ) -> Result<Self, PrimitiveError> {
        let mut builder = MixedSetBuilder::default();
        add(&mut builder)?;
        Ok(Self::Mixed(builder.finish()))
    }

    pub fn magnitude(&self) -> f64 {
        match self {
            Self::Triangles(set) => set.magnitude().to_f64(),
            Self::Mixed(set) => set.magnitude().to_f64(),
        }
    }

    pub fn bounds(&self, id: u32) -> Aabb<S> {
        match self {
            Self::Triangles(set) => set.bounds(id),
            Self::Mixed(set) => set.bounds(id),
        }
    }

    /// The corners of its triangles, which f64 holds exactly; none where it has other primitives.
    pub fn corners(&self) -> Option<Vec<Corners>> {
        let Self::Triangles(set) = self else { return None };
        let exact = |point: &[S; 3]| DVec3::from_array(point.map(S::to_f64));
        Some(set.triangles().iter().map(|triangle| triangle.each_ref().map(exact)).collect())
    }

    pub fn len(&self) -> usize {
        match self {
            Self::Triangles(set) => set.len(),
            Self::Mixed(set) => set.len(),
        }
    }

    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The primitives, for a structure to be built over.
    pub fn prims(&self) -> PrimsRef<'_, S> {
        match self {
            Self::Triangles(set) => PrimsRef::Watertight(set),
            Self::Mixed(set) => PrimsRef::Mixed(set),
        }
    }
}

/// A ray with the interval [0, infinity], rounded to `S`.
pub fn ray<S: Scalar>(origin: DVec3, direction: DVec3) -> Ray<S> {
    Ray::from_dvec3(origin, direction)
}
