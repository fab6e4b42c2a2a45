//! The region query: which primitives may a beam or a cone meet?
//!
//! Beside the question of a ray, which [`crate::query::tracer::Tracer`] answers, some structures
//! answer that of a [`Frustum`]: they visit the cells that it meets, near ones first. In f64 only:
//! what traces frusta computes areas, not crossings.
//!
//! Structures that do so implement [`FrustumTraversal`] and have a line in
//! [`crate::structures::frustum_queries::REGISTRY`].

mod frustum;
mod frustum_queries;

pub use frustum::{AxisFrustum, Frustum};
pub(crate) use frustum_queries::BoundFrustumQueries;
pub use frustum_queries::FrustumTraversal;
pub use frustum_queries::{Candidates, FrustumQueries, FrustumWork};
