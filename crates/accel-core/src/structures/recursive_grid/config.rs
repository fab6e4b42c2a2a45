//! The settings of the recursive grid.

use crate::config;
use crate::params::{ParamSpec, specs};
use crate::query::{kernel, mailbox};

/// The traversal recurses once a level.
const MAX_DEPTH: u64 = 8;

config! {
    /// How grids within grids are built.
    pub struct RecursiveGridConfig {
        /// levels of grids, the outermost included
        pub(super) max_depth: u32 = ParamSpec::integer("max-depth", "4", 1, MAX_DEPTH),
        /// rule for the voxels of every grid
        pub(super) rule: LevelRule = ParamSpec::choice(
            "resolution", "density", &["density", "heterogeneous", "cube-root"]
        ) => |rule| match rule {
            "heterogeneous" => LevelRule::Heterogeneous,
            "cube-root" => LevelRule::CubeRoot,
            _ => LevelRule::Density,
        },
        /// voxels per primitive of the outermost grid
        pub(super) top_density: f64 = ParamSpec::real("top-density", "1", 1e-6, 1e6),
        /// voxels per reference of the grids inside
        pub(super) density: f64 = ParamSpec { default: "1", ..specs::DENSITY },
        /// voxels with more references are divided
        pub(super) threshold: usize = ParamSpec::integer("threshold", "8", 1, 1 << 31),
        /// a voxel stays undivided if its grid held more times its references
        pub(super) max_growth: f64 = ParamSpec::real("max-growth", "16", 1.0, 1e9),
        /// all grids at once, or deep ones when a ray enters their voxel
        pub(super) is_lazy: bool = ParamSpec::choice("build", "eager", &["eager", "lazy"]) => |build| build == "lazy",
        /// levels that build=lazy makes at once
        pub(super) lazy_levels: u32 = ParamSpec::integer("lazy-levels", "1", 1, MAX_DEPTH),
        pub(super) historical: bool = specs::BOXES => specs::is_historical,
        pub(super) max_cells: u64 = specs::MAX_CELLS,
        pub(super) max_references: u64 = specs::MAX_REFERENCES,
        pub(super) has_joined_lists: bool = kernel::PARAM => |kernel| kernel == "block",
    }
    and mailbox::PARAM, mailbox::SLOTS_PARAM
}

/// How the voxels of a level are counted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum LevelRule {
    /// Cubes, D a reference, flat voxels included.
    Density,
    /// s_i (D n / V)^(1/3), rounded as in 1999.
    Heterogeneous,
    /// n^(1/3) on every axis, rounded up.
    CubeRoot,
}
