//! The cells of an irregular grid, as they were before their boxes grew.

use glam::DVec3;

use crate::geometry::aabb::Aabb;
use crate::geometry::scalar::Scalar;
use crate::query::cells::{Cell, CellVisitor};
use crate::structures::irregular_grid::IrregularGrid;
use crate::structures::irregular_grid::empty_boxes::EmptyBoxes;
use crate::structures::irregular_grid::lattice::Division;

impl<S: Scalar> IrregularGrid<S> {
    /// Calls `each` with the top grid and all within.
    pub(super) fn show(&self, each: &mut CellVisitor<'_>) {
        each(Cell::inner(self.bounds([0; 3], self.lattice.resolution()), 0));
        self.show_parts(0, &self.lattice.whole(), 1, each);
    }

    /// The parts of a division whose records begin at a number.
    fn show_parts(
        &self,
        begin: usize,
        division: &Division,
        depth: u32,
        each: &mut CellVisitor<'_>,
    ) {
        let voxels = &self.voxels.records[begin..begin + division.count()];
        let is_empty = |part: usize| !voxels[part].is_divided() && voxels[part].list() == 0;
        let empty = EmptyBoxes::new(division.parts, is_empty);
        let mut ids = Vec::new();
        for (part, voxel) in voxels.iter().enumerate() {
            let first = division.part(part);
            let end = |parts: [u32; 3]| {
                std::array::from_fn(|k| first[k] + (parts[k] << division.shift[k]))
            };
            if voxel.is_divided() {
                each(Cell::inner(self.bounds(first, end([1; 3])), depth));
                let (inner, begin) = voxel.division(first, division.shift);
                self.show_parts(begin, &inner, depth + 1, each);
            } else if is_empty(part) {
                // one cell of several parts
                let (corner, last) = empty.around(part);
                if corner == part {
                    let parts = division.place(part);
                    let count = std::array::from_fn(|k| last[k] + 1 - parts[k]);
                    each(Cell::elementary(self.bounds(first, end(count)), depth, &[]));
                }
            } else {
                self.lists.ids(voxel.list(), &mut ids);
                each(Cell::elementary(self.bounds(first, end([1; 3])), depth, &ids));
            }
        }
    }

    /// Between two points of the lattice.
    fn bounds(&self, first: [u32; 3], end: [u32; 3]) -> Aabb<f64> {
        let at =
            |p: [u32; 3]| DVec3::from_array(std::array::from_fn(|k| self.lattice.plane(k, p[k])));
        Aabb { min: at(first), max: at(end) }
    }
}
