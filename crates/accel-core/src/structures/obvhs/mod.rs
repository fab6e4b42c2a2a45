//! Bounding volume hierarchies of the crate `obvhs`, as its authors use them.

pub(crate) mod adapter;
mod builder;
pub mod bvh2;
pub mod cwbvh;
mod direct;
mod leaf_blocks;
