//! Building blocks of hierarchies.

pub(crate) mod build;
pub(crate) mod cluster_bvh;
pub mod clustering;
pub(crate) mod median_cut;
pub(crate) mod ray_planes;
