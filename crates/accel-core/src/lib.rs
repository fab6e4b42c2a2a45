//! Geometry, primitives and acceleration structures for ray tracing, with the work counters of
//! Havran and Sixta (1999).
//!
//! How the parts meet:
//! * [`primitives::PrimSet`] owns geometry and answers "where does this ray hit primitive `id`?".
//! * [`structure::Structure`] owns ids only. It is built from bounds and *walks* a ray, pushing
//!   candidate ids into a [`query::sink::Sink`].
//! * A [`query::sink::Sink`] is the query: closest hit or occlusion, with or without
//!   [`query::counters::Counters`]. A traversal is therefore written once for all queries. Lists of
//!   triangles may be kept as [`primitives::TriangleBlock`]s, which a sink tests at once and counts
//!   as the triangles they are. The irregular grid has one more traversal, for batches of rays with
//!   several on their way at once ([`structure::Batches`]).
//! * [`query::tracer::Tracer`] is the object-safe face of a built structure: one dynamic call for a
//!   whole batch of rays, everything inside it static.
//! * [`query::region::Gatherer`] answers the other question, which primitives a beam or cone may meet.
//! * [`structures::REGISTRY`] lists the structures: one line each.

pub mod geometry;
pub mod grid;
pub mod historical;
pub mod memory;
pub mod occluders;
mod parallel;
pub mod params;
pub mod primitives;
pub mod query;
pub mod registry;
mod room;
pub mod structure;
pub mod structures;
pub mod tree;
pub mod variants;

pub use geometry::aabb::Aabb;
pub use geometry::ray::{Hit, MISS, Ray};
pub use geometry::scalar::{Scalar, Vec3, Vector};
