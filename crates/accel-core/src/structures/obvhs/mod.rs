//! Bounding volume hierarchies of the crate `obvhs`.

pub(crate) mod adapter;
pub(crate) mod box_ray;
pub(crate) mod builder;
pub mod bvh2;
pub mod cwbvh;
pub(crate) mod direct;
mod direct_builder;
pub(crate) mod items;
mod leaf_blocks;
mod refit;
