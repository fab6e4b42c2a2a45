//! Insertion of boxes into the cells of a grid that they touch.

use crate::geometry::aabb::Aabb;
use crate::geometry::scalar::Scalar;
use crate::grid::block_lists::BlockPlacement;
use crate::grid::cell_lists::Placement;
use crate::grid::voxel_traversal::GridFrame;

/// Primitive `id` goes to every cell that its box touches.
pub(crate) struct BoxPlacement<'a, S: Scalar> {
    pub frame: GridFrame<S>,
    pub boxes: &'a [Aabb<S>],
    /// Cell indices by division, as in 1999.
    pub by_division: bool,
}

impl<S: Scalar> BlockPlacement for BoxPlacement<'_, S> {
    #[inline(always)]
    fn block(&self, id: u32) -> ([i32; 3], [i32; 3]) {
        let b = &self.boxes[id as usize];
        if self.by_division { self.frame.range_by_division(b) } else { self.frame.range(b) }
    }
}

impl<S: Scalar> Placement for BoxPlacement<'_, S> {
    #[inline(always)]
    fn cells_of(&self, id: u32, mut emit: impl FnMut(usize)) {
        let (first, last) = self.block(id);
        for z in first[2]..=last[2] {
            for y in first[1]..=last[1] {
                let row = self.frame.index([0, y, z]);
                for x in first[0]..=last[0] {
                    emit(row + x as usize);
                }
            }
        }
    }
}
