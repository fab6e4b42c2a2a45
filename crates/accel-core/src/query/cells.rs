//! Cells of a structure, for pictures and tests. Traversals do not use this.

use crate::geometry::aabb::Aabb;
use crate::geometry::scalar::Scalar;

/// The kind of a cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CellKind {
    /// A node of a hierarchy, a grid, or a voxel that holds grids: counted by
    /// [`StructureStats::inner_cells`](crate::structure::StructureStats::inner_cells).
    Inner,
    /// An elementary cell that lists primitives.
    Leaf,
    /// An elementary cell that lists none.
    Empty,
}

/// A voxel, a node or a leaf.
#[derive(Debug, Clone, Copy)]
pub struct Cell<'a> {
    /// Its box, world units; infinite where the structure has none. Of a sphere or of slabs, a box
    /// around them; of a cell whose box has grown over its neighbours, the cell.
    pub bounds: Aabb<f64>,
    /// 0 for the outermost.
    pub depth: u32,
    pub kind: CellKind,
    /// The primitives that it lists, as they are tested. Inner cells list none but where voxels
    /// hold primitives and grids alike.
    pub ids: &'a [u32],
}

impl<'a> Cell<'a> {
    pub fn elementary<S: Scalar>(bounds: Aabb<S>, depth: u32, ids: &'a [u32]) -> Self {
        let kind = if ids.is_empty() { CellKind::Empty } else { CellKind::Leaf };
        Self { bounds: bounds.in_double(), depth, kind, ids }
    }

    /// A cell that holds others.
    pub fn inner<S: Scalar>(bounds: Aabb<S>, depth: u32) -> Self {
        Self { bounds: bounds.in_double(), depth, kind: CellKind::Inner, ids: &[] }
    }
}

/// Takes a structure's cells: a cell comes before those within it, and these, each with one more of
/// depth, before the next cell that is no deeper.
pub type CellVisitor<'v> = dyn FnMut(Cell<'_>) + 'v;

/// Why a structure shows no cells.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("its cells cannot be shown: {0}")]
pub struct NoCells(pub &'static str);

impl NoCells {
    /// The structure does not describe its cells.
    pub const UNTOLD: Self = Self("it does not say what they are");
}
