//! The settings of the hierarchy of slabs.

use crate::config;
use crate::params::ParamSpec;
use crate::query::kernel;
use crate::structures::bounding_volumes::{DIRECTIONS, MAX_CELLS};

config! {
    /// How the hierarchy is built.
    pub struct KayKajiyaConfig {
        pub(super) directions: u64 = DIRECTIONS,
        /// primitives that a leaf may hold
        pub(super) leaf_size: usize = ParamSpec::integer("leaf-size", "1", 1, 1 << 20),
        /// children that a node may have
        pub(super) branching: usize = ParamSpec::choice("branching", "2", &["2", "4", "8"]),
        pub(super) max_cells: u64 = MAX_CELLS,
    }
    and kernel::PARAM
}
