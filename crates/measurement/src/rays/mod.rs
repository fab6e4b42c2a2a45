//! The rays that are replayed to every row.

pub mod batches;
pub mod exactness;
pub mod order;
pub mod reordered;
pub mod text;
