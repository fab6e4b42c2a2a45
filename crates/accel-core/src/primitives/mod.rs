//! Geometry that rays are tested against.
//!
//! * [`TriangleSet`]: triangles alone, fast and fair against a BVH library.
//! * [`MixedSet`]: triangles, polygons, spheres and cones under one id space, moving or at rest.

use crate::geometry::scalar::Scalar;

pub(crate) mod block_tests;
pub(crate) mod blocks;
mod chord;
mod collinear;
mod cone;
mod confirmed_copies;
pub(crate) mod instances;
pub(crate) mod mixed;
pub(crate) mod motion;
mod moving;
mod polygon;
mod precise;
pub(crate) mod prim_set;
mod shear;
mod shear_lanes;
mod sphere;
mod support;
pub(crate) mod triangle;
pub(crate) mod triangle_block;
pub(crate) mod watertight;

pub use cone::Cone;
pub use instances::{Instance, Instances};
pub use mixed::MixedSet;
pub use mixed::builder::MixedSetBuilder;
pub use moving::MovingSet;
pub use polygon::{Polygon, newell_normal};
pub(crate) use prim_set::IdSet;
pub use prim_set::{PrimSet, PrimitiveError, PrimitiveKind, Primitives};
pub use shear::Shear;
pub use sphere::{RearrangedSphere, Sphere, SphereTest};
pub use support::Ball;
pub use triangle::{MoellerTrumbore, MoellerTrumboreWithin, TriangleSet, TriangleTest, Watertight};
pub use triangle_block::TriangleBlock;

/// A set of primitives, whichever.
#[derive(Clone, Copy)]
pub enum PrimsRef<'a, S: Scalar> {
    /// Triangles with the watertight test.
    Watertight(&'a TriangleSet<S>),
    /// Primitives of any kind.
    Mixed(&'a MixedSet<S>),
}

impl<'a, S: Scalar> PrimsRef<'a, S> {
    /// The set as what is built over it sees it.
    pub fn primitives(self) -> &'a dyn Primitives<S> {
        match self {
            Self::Watertight(set) => set,
            Self::Mixed(set) => set,
        }
    }
}
