//! The settings of the octree.

use crate::config;
use crate::params::{ParamKind, ParamSpec, specs};
use crate::query::{kernel, mailbox};

/// Deepest cell; the root has depth 0.
pub(super) const DEEPEST: usize = 20;

config! {
    /// How an octree is built and traversed.
    pub struct OctreeConfig {
        /// cuts at the cell's centre, or between it and the objects' by least cost
        pub(super) adaptive: bool = ParamSpec::choice("subdivision", "centre", &["centre", "adaptive"]) => |s| s == "adaptive",
        /// point-location from the root (Glassner 1984), neighbour finding (Samet 1989), top-down
        /// (Gargantini, Atkinson 1993)
        pub(super) traversal: Traversal = ParamSpec::choice(
            "traversal", "top-down", &["point-location", "neighbour", "top-down"]
        ) => |traversal| match traversal {
            "point-location" => Traversal::PointLocation,
            "neighbour" => Traversal::Neighbour,
            _ => Traversal::TopDown,
        },
        /// depth of the smallest cells; the root has depth 0
        pub(super) max_depth: usize = ParamSpec::integer("max-depth", "16", 0, DEEPEST as u64),
        /// a cell with at most this many references is not cut
        pub(super) max_leaf: usize = ParamSpec::integer("max-leaf", "6", 0, 1 << 20),
        /// cuts in one line of descent that may fail to lower the expected cost
        pub(super) useless_splits: u64 = ParamSpec::integer("useless-splits", "1", 0, DEEPEST as u64),
        /// what the cuts in one line of descent may multiply references by, and so most references
        /// to a primitive on average; no limit for historical boxes
        pub(super) max_growth: f64 = ParamSpec::real("max-growth", "256", 1.0, 1e9),
        pub(super) historical: bool = specs::BOXES => specs::is_historical,
        /// order of ids in a leaf: as in the file or reversed; alternate turns it round from each
        /// level to the next, as in 1999
        pub(super) order: Order = ParamSpec {
            kind: ParamKind::Choice(&["file", "reverse", "alternate", "alternate-reverse"]),
            ..specs::ORDER
        } => |order| Order {
            alternates: order.starts_with("alternate"),
            is_reversed: order.ends_with("reverse"),
        },
        pub(super) max_cells: u64 = specs::max_cells(specs::MAX_CELLS.default, 1 << 30),
        pub(super) max_references: u64 = specs::max_references("268435456", (1 << 31) - 1),
    }
    and kernel::PARAM, mailbox::PARAM, mailbox::SLOTS_PARAM
}

/// How a ray finds the cells it meets.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Traversal {
    PointLocation,
    Neighbour,
    TopDown,
}

/// The order of ids in leaves.
#[derive(Debug, Clone, Copy)]
pub(super) struct Order {
    /// The lists of children are in the reverse order of their parent's.
    pub(super) alternates: bool,
    /// The root's list is not in that of the file.
    pub(super) is_reversed: bool,
}
