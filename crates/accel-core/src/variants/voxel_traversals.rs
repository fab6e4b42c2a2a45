//! Voxel traversals for comparison with `voxel_traversal.rs`: accumulating, and in f64.
//!
//! Paper: J. Amanatides, A. Woo, "A Fast Voxel Traversal Algorithm for Ray Tracing", Eurographics
//! 1987. Deviations: both start as `voxel_traversal.rs` does.

use crate::geometry::ray::Ray;
use crate::geometry::scalar::Scalar;
use crate::grid::cell_traversal::{CellPosition, CellTraversal};
use crate::grid::voxel_traversal::{GridFrame, VoxelTraversal};

/// A ray on its way through a grid, the parameter of the next plane accumulated as it was published:
/// each step adds a rounded length to a rounded sum, so that the error of a plane grows with the
/// number of steps and cells are passed by. It shows what that costs, and what it would save.
#[derive(Debug, Clone, Copy)]
pub struct AccumulatingTraversal<S: Scalar> {
    traversal: VoxelTraversal<S>,
    /// Parameter spent in one cell along each axis.
    per_cell: [S; 3],
}

impl<S: Scalar> GridFrame<S> {
    /// [`GridFrame::traversal_from`] with accumulated parameters.
    #[inline(always)]
    pub fn accumulating_traversal_from(
        &self,
        ray: &Ray<S>,
        t_start: S,
    ) -> Option<AccumulatingTraversal<S>> {
        let traversal = self.traversal_from(ray, t_start)?;
        Some(AccumulatingTraversal { per_cell: traversal.per_cell(), traversal })
    }
}

impl<S: Scalar> CellPosition for AccumulatingTraversal<S> {
    #[inline(always)]
    fn index(&self) -> usize {
        self.traversal.index()
    }

    #[inline(always)]
    fn coords(&self) -> [i32; 3] {
        self.traversal.coords()
    }
}

impl<S: Scalar> CellTraversal<S> for AccumulatingTraversal<S> {
    #[inline(always)]
    fn t_exit(&self) -> S {
        self.traversal.t_exit()
    }

    #[inline(always)]
    fn advance(&mut self) -> bool {
        let k = self.traversal.axis();
        if self.traversal.remaining[k] == 0 {
            return false;
        }
        self.traversal.remaining[k] -= 1;
        self.traversal.offset += self.traversal.stride[k];
        self.traversal.t_next[k] += self.per_cell[k];
        true
    }
}

/// A ray on its way through a grid in f64, whatever the scalar of primitives and rays is. The planes
/// are those of the grid in `S`; only the parameter at which a cell is left is rounded back.
#[derive(Debug, Clone, Copy)]
pub struct DoubleTraversal(VoxelTraversal<f64>);

impl DoubleTraversal {
    /// Starts a traversal at parameter `t_start`; `frame` is [`GridFrame::in_double`] of the
    /// grid's.
    #[inline(always)]
    pub fn from<S: Scalar>(frame: &GridFrame<f64>, ray: &Ray<S>, t_start: S) -> Option<Self> {
        frame.traversal_from(&ray.widened(), t_start.to_f64()).map(Self)
    }
}

impl CellPosition for DoubleTraversal {
    #[inline(always)]
    fn index(&self) -> usize {
        self.0.index()
    }

    #[inline(always)]
    fn coords(&self) -> [i32; 3] {
        self.0.coords()
    }
}

impl<S: Scalar> CellTraversal<S> for DoubleTraversal {
    #[inline(always)]
    fn t_exit(&self) -> S {
        S::from_f64(CellTraversal::<f64>::t_exit(&self.0))
    }

    #[inline(always)]
    fn advance(&mut self) -> bool {
        CellTraversal::<f64>::advance(&mut self.0)
    }
}
