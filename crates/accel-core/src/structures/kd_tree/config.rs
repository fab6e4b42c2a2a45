//! The settings of the k-d tree.

use super::cells::DEEPEST;
use crate::config;
use crate::params::{ParamSpec, specs};
use crate::query::{kernel, mailbox};

config! {
    /// How a k-d tree is built.
    pub struct KdTreeConfig {
        /// depth of the smallest cells; 0 for 8 + 1.3 log2(primitives)
        pub(super) max_depth: usize = ParamSpec::integer("max-depth", "0", 0, DEEPEST as u64),
        /// a cell with at most this many references is not cut
        pub(super) max_leaf: usize = ParamSpec::integer("max-leaf", "1", 0, 1 << 20),
        /// cost of going through an inner cell, in tests of primitives
        pub(super) traversal_cost: f64 = ParamSpec::real("traversal-cost", "1", 0.0, 1e6),
        /// part of the cost that a cut which makes an empty cell is spared
        pub(super) empty_bonus: f64 = ParamSpec::real("empty-bonus", "0.2", 0.0, 0.99),
        /// cuts in one line of descent that may fail to lower the expected cost
        pub(super) useless_splits: u64 = ParamSpec::integer("useless-splits", "2", 0, DEEPEST as u64),
        /// cells with at most this many references try every side of every box; larger ones 32
        /// planes per axis
        pub(super) exact_below: usize = ParamSpec::integer("exact-below", "64", 0, 1 << 32),
        pub(super) max_cells: u64 = specs::max_cells(specs::MAX_CELLS.default, 1 << 29),
        pub(super) max_references: u64 = specs::max_references("268435456", (1 << 31) - 1),
    }
    and kernel::PARAM, mailbox::PARAM, mailbox::SLOTS_PARAM
}
