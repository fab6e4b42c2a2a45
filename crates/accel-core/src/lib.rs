//! Geometry, primitives and acceleration structures for ray tracing, with the work counters of
//! Havran and Sixta (1999).
//!
//! How the parts meet:
//! * [`primitives::PrimSet`] owns geometry and answers "where does this ray hit primitive `id`?".
//! * [`structures::Structure`] owns ids only. It is built from bounds and *walks* a ray, pushing
//!   candidate ids into a [`sink::Sink`].
//! * A [`sink::Sink`] is the query: closest hit or occlusion, with or without
//!   [`counters::Counters`]. A traversal is therefore written once for all queries. The irregular
//!   grid has two more, for batches of rays among triangles alone, which it tests eight at a time:
//!   several rays on their way at once, or one after the other
//!   ([`structures::Structure::closest_batch`]).
//! * [`tracer::Tracer`] is the object-safe face of a built structure: one dynamic call for a
//!   whole batch of rays, everything inside it static.
//! * [`region::Gatherer`] answers the other question, which primitives a beam or cone may meet.
//! * [`structures::REGISTRY`] lists the structures: one line each.

pub mod aabb;
pub mod accumulating_walk;
mod block_lists;
pub mod bounds_rule;
mod box_placement;
pub mod box_test;
pub mod cell_lists;
pub mod cell_overlap;
pub mod cell_walk;
pub mod clustering;
pub mod counters;
pub mod distance_field;
pub mod double_walk;
pub mod driving_axis_walk;
pub mod far_ray;
pub mod lanes;
pub mod mailbox;
pub mod memory;
pub mod occluders;
mod parallel;
pub mod params;
pub mod primitives;
pub mod ray;
pub mod region;
pub mod resolution;
pub mod scalar;
pub mod sink;
pub mod structures;
pub mod tracer;
pub mod voxel_walk;

pub use aabb::Aabb;
pub use ray::{Hit, MISS, Ray};
pub use scalar::{Scalar, Vec3, Vector};
