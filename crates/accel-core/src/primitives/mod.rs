//! Geometry that rays are tested against.
//!
//! * [`TriangleSet`]: triangles alone, fast and fair against a BVH library.
//! * [`MixedSet`]: triangles, polygons, spheres and cones under one id space, moving or at rest.
//! * [`RetestedSet`]: a mixed set under other tests, compiled in.
//! * [`ChosenTests`](crate::variants::chosen_tests::ChosenTests): either of them under tests that
//!   are chosen at run time.

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
mod prim_set;
mod prims_ref;
mod retested;
mod shear;
mod shear_lanes;
mod sphere;
mod support;
mod tagged;
pub(crate) mod triangle;
mod triangle_block;
pub(crate) mod watertight;

pub use cone::Cone;
pub use instances::{Instance, Instances};
pub use mixed::{MixedSet, MixedSetBuilder};
pub use moving::MovingSet;
pub use polygon::{Polygon, newell_normal};
pub(crate) use prim_set::TransmissiveSet;
pub use prim_set::{PrimSet, PrimitiveError, PrimitiveKind};
pub use prims_ref::PrimsRef;
pub use retested::RetestedSet;
pub use shear::Shear;
pub use sphere::{RearrangedSphere, Sphere, SphereTest};
pub use support::Ball;
pub use triangle::{MoellerTrumbore, TriangleSet, TriangleTest, Watertight};
pub use triangle_block::TriangleBlock;
