//! The voxel walk as it was published: the parameter of the next plane is accumulated.
//!
//! Paper: J. Amanatides, A. Woo, "A Fast Voxel Traversal Algorithm for Ray Tracing", Eurographics
//! 1987. Deviations: none but the start, which is that of `voxel_walk.rs`. Each step adds a rounded
//! length to a rounded sum, so that the error of a plane grows with the number of steps and cells
//! are passed by: this walk is here to show what that costs, and what it would save.

use crate::geometry::ray::Ray;
use crate::geometry::scalar::Scalar;
use crate::grid::cell_walk::{CellPosition, CellWalk};
use crate::grid::voxel_walk::{GridFrame, VoxelWalk};

/// A ray on its way through a grid.
#[derive(Debug, Clone, Copy)]
pub struct AccumulatingWalk<S: Scalar> {
    walk: VoxelWalk<S>,
    /// Parameter spent in one cell along each axis.
    per_cell: [S; 3],
}

impl<S: Scalar> GridFrame<S> {
    /// [`GridFrame::walk_from`] with accumulated parameters.
    #[inline(always)]
    pub fn accumulating_walk_from(&self, ray: &Ray<S>, t_start: S) -> Option<AccumulatingWalk<S>> {
        self.walk_from(ray, t_start).map(AccumulatingWalk::new)
    }
}

impl<S: Scalar> AccumulatingWalk<S> {
    /// Goes on from where `walk` is.
    #[inline(always)]
    pub fn new(walk: VoxelWalk<S>) -> Self {
        let per_cell = std::array::from_fn(|k| (walk.cell[k] * walk.inv_d[k]).abs());
        Self { walk, per_cell }
    }
}

impl<S: Scalar> CellPosition for AccumulatingWalk<S> {
    #[inline(always)]
    fn index(&self) -> usize {
        self.walk.index()
    }

    #[inline(always)]
    fn coords(&self) -> [i32; 3] {
        self.walk.coords()
    }
}

impl<S: Scalar> CellWalk<S> for AccumulatingWalk<S> {
    #[inline(always)]
    fn t_exit(&self) -> S {
        self.walk.t_exit()
    }

    #[inline(always)]
    fn advance(&mut self) -> bool {
        let k = self.walk.axis();
        if self.walk.remaining[k] == 0 {
            return false;
        }
        self.walk.remaining[k] -= 1;
        self.walk.offset += self.walk.stride[k];
        self.walk.t_next[k] += self.per_cell[k];
        true
    }
}
