//! Bounding volume hierarchies of the crate `obvhs`.

pub(crate) mod adapter;
pub(crate) mod builder;
pub mod bvh2;
pub mod cwbvh;
pub(crate) mod direct;
mod direct_builder;
mod leaf_blocks;
