//! Questions to a structure: closest hit, any hit, what a shaft meets; and what answering costs.

pub mod counters;
pub(crate) mod in_flight;
pub mod kernel;
pub(crate) mod lists;
pub mod mailbox;
pub mod region;
pub mod sink;
pub mod tracer;
