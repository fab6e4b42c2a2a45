//! Geometry, primitives and acceleration structures for ray tracing, with the work counters of
//! Havran and Sixta (1999).
//!
//! A structure over some triangles, and rays traced through it:
//!
//! ```
//! use accel_core::glam::Vec3;
//! use accel_core::primitives::{PrimsRef, TriangleSet};
//! use accel_core::structures::find;
//! use accel_core::{Hit, Ray};
//!
//! // two triangles over the unit square: the lower one, then one that is a unit above it
//! let at = |z: f32| [[0.0, 0.0, z], [2.0, 0.0, z], [0.0, 2.0, z]];
//! let triangles = TriangleSet::new(vec![at(0.0), at(1.0)], |_| false)?;
//!
//! let grid = find("uniform-grid").ok_or("there is none")?;
//! let params = grid.defaults().set("density", 4)?;
//! let tracer = grid.build::<f32>(PrimsRef::Watertight(&triangles), &params)?;
//!
//! let rays = [
//!     Ray::new(Vec3::new(0.5, 0.5, 3.0), Vec3::NEG_Z),
//!     Ray::new(Vec3::new(0.5, 0.5, 3.0), Vec3::Z),
//! ];
//! let mut hits = [Hit::NONE; 2];
//! tracer.closest_hits(&rays, &mut hits);
//! assert_eq!((hits[0].id, hits[0].t), (1, 2.0));
//! assert!(!hits[1].is_hit());
//!
//! let mut blocked = [false; 2];
//! tracer.occlusions(&rays, &mut blocked);
//! assert_eq!(blocked, [true, false]);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! How the parts meet:
//! * [`primitives::PrimSet`] owns geometry and answers "where does this ray hit primitive `id`?".
//! * [`structure::Structure`] owns ids only. It is built over [`primitives::Primitives`], what a
//!   set says of where primitives are, and *traversed* by a ray, pushing candidate ids into a
//!   [`query::sink::Sink`].
//! * A [`query::sink::Sink`] is the query: closest hit or occlusion, with or without
//!   [`query::counters::Counters`]. A traversal is therefore written once for all queries. Lists of
//!   triangles may be kept as [`primitives::TriangleBlock`]s, which a sink tests at once and counts
//!   as the triangles they are. Batches of rays may be traversed side by side, or be
//!   prepared together ([`structure::Batches`]).
//! * [`query::tracer::Tracer`] is the object-safe face of a built structure: one dynamic call for a
//!   whole batch of rays, everything inside it static.
//! * [`query::region::FrustumQueries`] answers the other question, which primitives a beam or cone
//!   may meet.
//! * [`structures::REGISTRY`] lists the structures: one line each. [`entry!`] makes a line of a
//!   structure of yours, for `rtbench::main_with`; [`prelude`] has what that one needs, and does
//!   not change.

pub mod bvh;
mod capacity;
mod counting_sort;
pub mod geometry;
pub mod grid;
pub mod historical;
pub mod memory;
pub mod occluders;
mod parallel;
pub mod params;
pub mod prelude;
pub mod primitives;
pub mod query;
pub mod registry;
pub mod structure;
pub mod structures;
pub mod tree;
pub mod update;
pub mod variants;

/// The vectors of this crate's interface are those of this version of glam.
pub use glam;

pub use geometry::aabb::Aabb;
pub use geometry::ray::{Hit, MISS, Ray};
pub use geometry::scalar::{Scalar, Vec3, Vector};
