//! The region query: which primitives may a beam or a cone meet?
//!
//! Beside the question of a ray, which [`crate::query::tracer::Tracer`] answers, some structures
//! answer that of a [`Shaft`]: they visit the cells that it meets, near ones first. In f64 only: what
//! traces shafts computes areas, not crossings.
//!
//! Structures that do so implement [`ShaftWalk`] and have a line in
//! [`crate::structures::gatherers::REGISTRY`].

mod gatherer;
mod shaft;
mod shaft_walk;

pub(crate) use gatherer::BoundGatherer;
pub use gatherer::{Gathered, Gatherer, Work};
pub use shaft::{Across, Shaft};
pub use shaft_walk::ShaftWalk;
