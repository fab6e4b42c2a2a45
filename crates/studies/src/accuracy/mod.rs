//! Cost of accuracy in time: the plan of `rtbench accuracy`.
//!
//! An [`axis::Axis`] is one way to be more or less accurate: a test of triangles, a traversal, a
//! number of samples. It has variants, which are settings of the product and reachable without this
//! command as well, a metric of their errors, and a reference. On each scene an axis says what each
//! variant gets wrong, by an oracle of its own ([`axes`]), and what is to be timed; [`timing`]
//! times all variants interleaved and refuses what cannot be, [`pareto`] finds those that nothing
//! beats, [`summary`] says it in words.

#[allow(clippy::indexing_slicing)]
pub mod axes;
pub mod axis;
pub mod cost_tables;
#[allow(clippy::indexing_slicing)]
mod integer_ray;
pub mod pareto;
#[allow(clippy::indexing_slicing)]
pub mod pictures;
pub mod record;
pub mod report;
pub mod sampled;
pub mod stage;
pub mod summary;
pub mod timing;
