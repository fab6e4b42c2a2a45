//! A frustum's way through a regular grid: slice by slice across its longest axis, and in each the
//! rectangle of cells around the part of the frustum within.

use std::ops::ControlFlow;

use crate::geometry::scalar::Vector;
use crate::grid::regular_grid::{CellStorage, RegularGrid};
use crate::query::region::{Frustum, FrustumTraversal};

/// Rectangles of more cells than this have each cell tested by itself.
const FEW_CELLS: i32 = 4;

impl<G: CellStorage> FrustumTraversal for RegularGrid<f64, G> {
    fn traverse_frustum(
        &self,
        frustum: &Frustum,
        cell: &mut dyn FnMut(&[u32], f64) -> ControlFlow<()>,
    ) {
        let whole = self.frame.bounds().expanded(frustum.tolerance());
        if !frustum.meets_box(&whole) {
            return;
        }
        let axis = frustum.longest_axis();
        let (first, last) = self.frame.range(&frustum.bounds().expanded(frustum.tolerance()));
        let corner = self.frame.bounds().min.to_array()[axis];
        let thickness = self.frame.cell_size()[axis];
        let plane = |i: i32| corner + f64::from(i) * thickness;
        let overlaps =
            |a: &crate::Aabb<f64>| a.min.cmple(whole.max).all() && a.max.cmpge(whole.min).all();
        let count = last[axis] - first[axis] + 1;
        let upwards = frustum.direction()[axis] >= 0.0;
        let across = frustum.across(axis);
        let layers = (0..count).map(|i| if upwards { first[axis] + i } else { last[axis] - i });
        let mut slices: Vec<_> = layers
            .filter_map(|i| {
                let slice = across.slice(plane(i), plane(i + 1)).filter(overlaps)?;
                Some((i, frustum.least_depth(&slice), slice))
            })
            .collect();
        // what this slice and all later ones do not begin before
        let mut depth = f64::INFINITY;
        for (_, least, _) in slices.iter_mut().rev() {
            depth = depth.min(*least);
            *least = depth;
        }
        for (i, depth, slice) in slices {
            let (mut from, mut to) = self.frame.range(&slice);
            (from[axis], to[axis]) = (i, i);
            let cells = (0..3).map(|k| to[k] - from[k] + 1).product::<i32>();
            for z in from[2]..=to[2] {
                for y in from[1]..=to[1] {
                    for x in from[0]..=to[0] {
                        let at = self.frame.cell([x, y, z]);
                        let list = self.storage.list(&at);
                        if list.is_empty() {
                            continue;
                        }
                        if cells > FEW_CELLS {
                            let bounds = self.frame.cell_bounds(at.index);
                            if !frustum.meets_box(&bounds.expanded(frustum.tolerance())) {
                                continue;
                            }
                        }
                        if cell(list, depth).is_break() {
                            return;
                        }
                    }
                }
            }
        }
    }
}
