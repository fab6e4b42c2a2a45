//! Questions to a structure: closest hit, any hit, what a frustum meets; and what answering costs.

pub mod batch;
pub mod cells;
pub mod counters;
pub mod entered;
pub mod kernel;
pub(crate) mod lists;
pub mod mailbox;
pub(crate) mod ray_order;
pub mod region;
pub(crate) mod side_by_side;
pub mod sink;
pub mod trace;
pub mod tracer;
