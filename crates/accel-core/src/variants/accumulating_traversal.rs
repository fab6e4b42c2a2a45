//! The voxel traversal as it was published: the parameter of the next plane is accumulated.
//!
//! Paper: J. Amanatides, A. Woo, "A Fast Voxel Traversal Algorithm for Ray Tracing", Eurographics
//! 1987. Deviations: none but the start, which is that of `voxel_traversal.rs`. Each step adds a
//!       rounded
//! length to a rounded sum, so that the error of a plane grows with the number of steps and cells
//! are passed by: this traversal is here to show what that costs, and what it would save.

use crate::geometry::ray::Ray;
use crate::geometry::scalar::Scalar;
use crate::grid::cell_traversal::{CellPosition, CellTraversal};
use crate::grid::voxel_traversal::{GridFrame, VoxelTraversal};

/// A ray on its way through a grid.
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
        self.traversal_from(ray, t_start).map(AccumulatingTraversal::new)
    }
}

impl<S: Scalar> AccumulatingTraversal<S> {
    /// Goes on from where `traversal` is.
    #[inline(always)]
    pub fn new(traversal: VoxelTraversal<S>) -> Self {
        let per_cell = std::array::from_fn(|k| (traversal.cell[k] * traversal.inv_d[k]).abs());
        Self { traversal, per_cell }
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
