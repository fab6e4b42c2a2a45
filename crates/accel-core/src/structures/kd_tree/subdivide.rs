//! How a k-d tree is built: depth first, each cell cut where the heuristic says.

use super::super::BuildError;
use super::surface_area::{Cut, Heuristic};
use super::{Cells, DEEPEST, Node};
use crate::aabb::Aabb;
use crate::params::Params;
use crate::scalar::{Scalar, Vec3, Vector};

/// Builds the cells over boxes of primitives.
pub(super) fn cells<S: Scalar>(
    boxes: &[Aabb<S>],
    bounds: Aabb<S>,
    params: &Params,
) -> Result<Cells<S>, BuildError> {
    let max_depth = match params.integer("max-depth") {
        0 => (8.0 + 1.3 * (boxes.len().max(1) as f64).log2()) as usize,
        depth => depth as usize,
    };
    let mut builder = Builder {
        boxes,
        heuristic: Heuristic::new(params),
        max_depth: max_depth.min(DEEPEST),
        max_leaf: params.integer("max-leaf") as usize,
        useless_splits: params.integer("useless-splits"),
        max_cells: params.integer("max-cells"),
        max_references: params.integer("max-references"),
        structure: params.structure(),
        cells: Cells { nodes: vec![Node::leaf(0)], starts: vec![0], ids: Vec::new() },
        waiting: (0..boxes.len() as u32).collect(),
    };
    builder.cell(0, bounds, 0, 0, 0)?;
    Ok(builder.cells)
}

struct Builder<'a, S: Scalar> {
    boxes: &'a [Aabb<S>],
    heuristic: Heuristic<S>,
    max_depth: usize,
    max_leaf: usize,
    useless_splits: u64,
    max_cells: u64,
    max_references: u64,
    structure: &'static str,
    cells: Cells<S>,
    /// References of the cells on the way from the root, one list after the other.
    waiting: Vec<u32>,
}

impl<S: Scalar> Builder<'_, S> {
    /// Makes `cell` of the references `waiting[from..]`, which it takes away.
    fn cell(
        &mut self,
        cell: usize,
        bounds: Aabb<S>,
        depth: usize,
        from: usize,
        useless: u64,
    ) -> Result<(), BuildError> {
        let end = self.waiting.len();
        let n = end - from;
        if n <= self.max_leaf || depth == self.max_depth {
            return self.leaf(cell, from);
        }
        let cut = self.heuristic.best_cut(self.boxes, &self.waiting[from..], &bounds);
        let Some(Cut { axis, plane, cost }) = cut else { return self.leaf(cell, from) };
        let useless = useless + u64::from(cost >= n as f64);
        if useless > self.useless_splits {
            return self.leaf(cell, from);
        }
        let lower = self.cells.nodes.len();
        self.limit("number of cells", lower as u64 + 2, self.max_cells)?;
        self.cells.nodes[cell] = Node::inner(axis, plane, lower);
        self.cells.nodes.resize(lower + 2, Node::leaf(0));
        for side in 0..2 {
            for i in from..end {
                let id = self.waiting[i];
                let b = &self.boxes[id as usize];
                // boxes are padded: what ends on a plane has no point on its other side
                let inside = match side {
                    0 => b.min.to_array()[axis] < plane,
                    _ => b.max.to_array()[axis] > plane,
                };
                if inside {
                    self.waiting.push(id);
                }
            }
            let (mut lo, mut hi) = (bounds.min.to_array(), bounds.max.to_array());
            if side == 0 {
                hi[axis] = plane
            } else {
                lo[axis] = plane
            }
            let half = Aabb { min: Vec3::<S>::from_array(lo), max: Vec3::<S>::from_array(hi) };
            self.cell(lower + side, half, depth + 1, end, useless)?;
        }
        self.waiting.truncate(from);
        Ok(())
    }

    fn leaf(&mut self, cell: usize, from: usize) -> Result<(), BuildError> {
        let references = self.cells.ids.len() + self.waiting.len() - from;
        self.limit("references in cells", references as u64, self.max_references)?;
        self.cells.nodes[cell] = Node::leaf(self.cells.starts.len() - 1);
        self.cells.ids.extend_from_slice(&self.waiting[from..]);
        self.cells.starts.push(references as u32);
        self.waiting.truncate(from);
        Ok(())
    }

    fn limit(&self, what: &'static str, needed: u64, limit: u64) -> Result<(), BuildError> {
        if needed <= limit {
            return Ok(());
        }
        let (needed, limit) = (u128::from(needed), u128::from(limit));
        Err(BuildError::TooLarge { structure: self.structure, what, needed, limit })
    }
}
