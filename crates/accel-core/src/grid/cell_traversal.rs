//! Interface of traversals of regular grids, and the setting that chooses one.
//!
//! Two traversals are for use: `voxel_traversal.rs` (t_next stepping) and
//! `driving_axis_traversal.rs` (Fujimoto's synchronised DDAs). Two more are for comparison, in the
//! uniform grid alone: `variants/voxel_traversals.rs`. Storages and structures are written once,
//! over [`CellTraversal`].

use crate::geometry::scalar::Scalar;
use crate::params::{ParamKind, ParamSpec, Params};

/// A cell of a regular grid.
pub trait CellPosition {
    /// Its index, x fastest.
    fn index(&self) -> usize;
    fn coords(&self) -> [i32; 3];
}

/// A cell that no ray is in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct GridCell {
    pub index: usize,
    pub coords: [i32; 3],
}

impl CellPosition for GridCell {
    #[inline(always)]
    fn index(&self) -> usize {
        self.index
    }

    #[inline(always)]
    fn coords(&self) -> [i32; 3] {
        self.coords
    }
}

/// A ray on its way through a grid, in one of its cells.
pub trait CellTraversal<S: Scalar>: CellPosition {
    /// Parameter at which the ray leaves the current cell.
    fn t_exit(&self) -> S;
    /// Steps to the next cell; false when that would leave the grid.
    fn advance(&mut self) -> bool;
}

/// Traversal of a grid. The first two visit every pierced cell; they differ in time, and in the
/// cells visited where a ray meets an edge or corner of cells exactly.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Traversal {
    /// Amanatides and Woo 1987.
    #[default]
    TNext,
    /// Fujimoto, Tanaka and Iwata 1986.
    DrivingAxis,
    /// Amanatides and Woo 1987 to the letter: it passes cells by.
    Accumulate,
    /// Like [`Traversal::TNext`], computed in f64.
    Double,
}

impl Traversal {
    /// The setting, for the parameter list of a structure.
    pub const PARAM: ParamSpec =
        ParamSpec::choice("traversal", "t-next", &["t-next", "driving-axis"]).about(
            "step to the nearest of three planes, or along a driving axis (Fujimoto's 3D-DDA)",
        );

    /// The same with the traversals that are there for comparison.
    pub const PARAM_OF_ALL: ParamSpec = ParamSpec {
        summary: "step to the nearest of three planes, or along a driving axis (Fujimoto's \
                  3D-DDA); for comparison: accumulate (as published, passes cells by), f64",
        kind: ParamKind::Choice(&["t-next", "driving-axis", "accumulate", "f64"]),
        ..Self::PARAM
    };

    /// Reads the setting; [`Self::TNext`] for a structure without the parameter.
    pub fn of(params: &Params) -> Self {
        match params.get(Self::PARAM.name) {
            Some("driving-axis") => Self::DrivingAxis,
            Some("accumulate") => Self::Accumulate,
            Some("f64") => Self::Double,
            _ => Self::TNext,
        }
    }
}
