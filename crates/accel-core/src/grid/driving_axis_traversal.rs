//! The traversal of a ray through a regular grid by two synchronised DDAs: one driving axis, two
//! passive ones.
//!
//! Paper: A. Fujimoto, T. Tanaka, K. Iwata, "ARTS: Accelerated Ray-Tracing System", IEEE Computer
//! Graphics and Applications 6(4), 1986 (the 3D-DDA).
//!
//! The axis along which the ray crosses most cells drives: each of its steps enters the next layer
//! of cells. An error term for each passive axis says whether its plane is met before the layer
//! ends; then it steps too. Two planar DDAs share the driving axis.
//!
//! Deviations. As a drawing algorithm the scheme lights one cell per column, and two DDAs that both
//! step in one layer do so in a fixed order: either way pierced cells are missed. Here all passive
//! steps of a layer are made one after the other, the larger error (the earlier plane) first, and
//! before the driving step. Error terms are kept as parameters, (end of the layer) - (next passive
//! plane), whose sign is that of Fujimoto's error in cells, and are recomputed from plane indices
//! instead of accumulated, as in `voxel_traversal.rs`; so both traversals make the same
//! comparisons. Ties: the driving axis goes first, then the lower passive axis.

use crate::geometry::ray::Ray;
use crate::geometry::scalar::Scalar;
use crate::grid::cell_traversal::{CellPosition, CellTraversal};
use crate::grid::voxel_traversal::{GridFrame, VoxelTraversal};

/// One axis of the traversal.
#[derive(Debug, Clone, Copy)]
struct Axis<S: Scalar> {
    /// Parameter at which its next plane is met.
    t_next: S,
    /// Index of that plane.
    plane: S,
    plane_step: S,
    cell: S,
    from_origin: S,
    inv_d: S,
    remaining: i32,
    stride: isize,
}

impl<S: Scalar> Axis<S> {
    #[inline(always)]
    fn of(traversal: &VoxelTraversal<S>, k: usize) -> Self {
        Self {
            t_next: traversal.t_next[k],
            plane: traversal.plane[k],
            plane_step: traversal.plane_step[k],
            cell: traversal.cell[k],
            from_origin: traversal.from_origin[k],
            inv_d: traversal.inv_d[k],
            remaining: traversal.remaining[k],
            stride: traversal.stride[k],
        }
    }

    /// Steps to the next plane and gives the change of the cell's index.
    #[inline(always)]
    fn step(&mut self) -> Option<isize> {
        if self.remaining == 0 {
            return None;
        }
        self.remaining -= 1;
        self.plane += self.plane_step;
        self.t_next = (self.plane * self.cell + self.from_origin) * self.inv_d;
        Some(self.stride)
    }
}

/// A ray on its way through a grid, layer by layer of the driving axis.
#[derive(Debug, Clone, Copy)]
pub struct DrivingAxisTraversal<S: Scalar> {
    driving: Axis<S>,
    /// The two others, the lower one first.
    passive: [Axis<S>; 2],
    offset: isize,
    /// Axis numbers: driving, passive, passive.
    axes: [usize; 3],
    last: [i32; 3],
    step: [i32; 3],
}

impl<S: Scalar> GridFrame<S> {
    /// [`GridFrame::traversal_from`] along the driving axis.
    #[inline(always)]
    pub fn driving_traversal_from(
        &self,
        ray: &Ray<S>,
        t_start: S,
    ) -> Option<DrivingAxisTraversal<S>> {
        let traversal = self.traversal_from(ray, t_start)?;
        // least along the driving axis
        let per_cell = traversal.per_cell();
        let [x, y, z] = per_cell;
        let axes = if x <= y && x <= z {
            [0, 1, 2]
        } else if y <= z {
            [1, 0, 2]
        } else {
            [2, 0, 1]
        };
        Some(DrivingAxisTraversal {
            driving: Axis::of(&traversal, axes[0]),
            passive: [Axis::of(&traversal, axes[1]), Axis::of(&traversal, axes[2])],
            offset: traversal.offset,
            axes,
            last: traversal.last,
            step: traversal.step,
        })
    }
}

impl<S: Scalar> DrivingAxisTraversal<S> {
    /// Returns whether the passive plane `p` is met before the layer ends: Fujimoto's error is
    /// positive.
    #[inline(always)]
    fn is_due(&self, p: usize) -> bool {
        self.passive[p].t_next < self.driving.t_next
    }

    /// The passive axis with the larger error, when one is due.
    #[inline(always)]
    fn due(&self) -> Option<usize> {
        match (self.is_due(0), self.is_due(1)) {
            (false, false) => None,
            (true, false) => Some(0),
            (false, true) => Some(1),
            (true, true) => Some(usize::from(self.passive[1].t_next < self.passive[0].t_next)),
        }
    }
}

impl<S: Scalar> CellPosition for DrivingAxisTraversal<S> {
    #[inline(always)]
    fn index(&self) -> usize {
        self.offset as usize
    }

    #[inline(always)]
    fn coords(&self) -> [i32; 3] {
        let mut at = self.last;
        let [d, p, q] = self.axes;
        at[d] -= self.step[d] * self.driving.remaining;
        at[p] -= self.step[p] * self.passive[0].remaining;
        at[q] -= self.step[q] * self.passive[1].remaining;
        at
    }
}

impl<S: Scalar> CellTraversal<S> for DrivingAxisTraversal<S> {
    #[inline(always)]
    fn t_exit(&self) -> S {
        match self.due() {
            None => self.driving.t_next,
            Some(0) => self.passive[0].t_next,
            Some(_) => self.passive[1].t_next,
        }
    }

    #[inline(always)]
    fn advance(&mut self) -> bool {
        let stride = match self.due() {
            None => self.driving.step(),
            Some(0) => self.passive[0].step(),
            Some(_) => self.passive[1].step(),
        };
        self.offset += stride.unwrap_or(0);
        stride.is_some()
    }
}
