//! Grids whose cells hold primitives and further grids: what HUG and the adaptive grid are made of.
//!
//! All cells of all grids stand in one array, their ids in two more. The traversal is a recursion
//! over nested grids, as deep as the builder nests them (each builder has a limit).

pub(crate) mod build;

use std::collections::HashSet;
use std::ops::ControlFlow;

use crate::geometry::aabb::Aabb;
use crate::geometry::ray::Ray;
use crate::geometry::scalar::Scalar;
use crate::grid::cell_traversal::{CellPosition, CellTraversal};
use crate::grid::voxel_traversal::GridFrame;
use crate::query::cells::{Cell, CellKind, CellVisitor};
use crate::query::mailbox::Mailbox;
use crate::query::sink::Sink;

#[derive(Debug, Clone, Copy)]
struct Grid<S: Scalar> {
    frame: GridFrame<S>,
    first_cell: u32,
}

/// Starts of the lists of a cell; they end at the starts of the next cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct CellStart {
    ids: u32,
    grids: u32,
}

/// The grids. Number 0 is the first one pushed.
pub(crate) struct NestedGrids<S: Scalar, I = u32> {
    grids: Vec<Grid<S>>,
    /// One more than there are cells.
    starts: Vec<CellStart>,
    ids: Vec<u32>,
    /// The numbers of grids within cells, or what tells these.
    inner: Vec<I>,
}

impl<S: Scalar> NestedGrids<S> {
    /// The references of all cells.
    pub(crate) fn lists(&self) -> impl Iterator<Item = &[u32]> {
        self.starts.windows(2).filter_map(|at| self.ids.get(at[0].ids as usize..at[1].ids as usize))
    }

    /// Number of grids so far.
    pub(crate) fn len(&self) -> usize {
        self.grids.len()
    }

    /// Cells that hold no inner grid; empty ones among them; cells that do; references to
    /// primitives in all of them.
    pub(crate) fn census(&self) -> Census {
        let mut census = Census { references: self.ids.len() as u64, ..Census::default() };
        for w in self.starts.windows(2) {
            if w[0].grids < w[1].grids {
                census.dividing_cells += 1;
            } else {
                census.cells += 1;
                census.empty_cells += u64::from(w[0].ids == w[1].ids);
            }
        }
        census
    }

    /// Calls `each` with the cells of a grid, and with those of the grids within that are not in
    /// `seen`: as cells within a cell or, where none is in two cells (`are_unique`), with the grids
    /// in place of the cells that hold them.
    pub(crate) fn show(
        &self,
        grid: u32,
        depth: u32,
        are_unique: bool,
        seen: &mut HashSet<u32>,
        each: &mut CellVisitor<'_>,
    ) {
        let Some(grid) = self.grids.get(grid as usize).filter(|_| seen.insert(grid)) else {
            return;
        };
        for index in 0..grid.frame.cells() {
            let cell = grid.first_cell as usize + index;
            let (from, to) = (self.starts[cell], self.starts[cell + 1]);
            let ids = &self.ids[from.ids as usize..to.ids as usize];
            let inner = &self.inner[from.grids as usize..to.grids as usize];
            let elementary = Cell::elementary(grid.frame.cell_bounds(index), depth, ids);
            match (inner, are_unique) {
                ([], _) => each(elementary),
                (_, true) => {}
                (_, false) => each(Cell { kind: CellKind::Inner, ..elementary }),
            }
            for &inner in inner {
                if are_unique {
                    each(Cell::inner(self.bounds(inner), depth));
                }
                self.show(inner, depth + 1, are_unique, seen, each);
            }
        }
    }

    /// Bounds of a grid.
    pub(crate) fn bounds(&self, grid: u32) -> Aabb<S> {
        self.grids.get(grid as usize).map_or(Aabb::empty(), |grid| grid.frame.bounds())
    }

    /// True when the ray meets the box of a grid.
    pub(crate) fn meets(&self, grid: u32, ray: &Ray<S>, t_start: S) -> bool {
        self.bounds(grid).clip(ray.origin, ray.direction, t_start, ray.t_max).is_some()
    }

    pub(crate) fn bytes(&self) -> u64 {
        (size_of_val(self.grids.as_slice())
            + size_of_val(self.starts.as_slice())
            + size_of_val(self.ids.as_slice())
            + size_of_val(self.inner.as_slice())) as u64
    }

    /// Traverses a grid and the grids within; `Break` when the sink ended the query. A grid that
    /// `visited` has seen is not traversed again.
    pub(crate) fn traverse<K: Sink<S>>(
        &self,
        grid: u32,
        ray: &Ray<S>,
        t_start: S,
        sink: &mut K,
        visited: &mut impl Mailbox,
    ) -> ControlFlow<()> {
        let Some(grid) = self.grids.get(grid as usize) else { return ControlFlow::Continue(()) };
        // what is farther than the best hit needs no traversal
        let ray_left = Ray { t_max: sink.t_max(), ..*ray };
        let Some(mut traversal) = grid.frame.traversal_from(&ray_left, t_start) else {
            return ControlFlow::Continue(());
        };
        loop {
            let cell = grid.first_cell as usize + traversal.index();
            let (Some(&from), Some(&to)) = (self.starts.get(cell), self.starts.get(cell + 1))
            else {
                return ControlFlow::Continue(());
            };
            if from.grids == to.grids {
                sink.elementary_step(from.ids == to.ids);
            } else {
                sink.inner_step();
            }
            if from.ids < to.ids
                && let Some(list) = self.ids.get(from.ids as usize..to.ids as usize)
            {
                sink.test(list)?;
            }
            if from.grids < to.grids {
                for i in from.grids..to.grids {
                    let Some(&inner) = self.inner.get(i as usize) else { continue };
                    if visited.is_new(inner) {
                        self.traverse(inner, ray, t_start, sink, visited)?;
                    }
                }
            }
            if sink.t_max() < traversal.t_exit() || !traversal.advance() {
                return ControlFlow::Continue(());
            }
        }
    }
}

#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct Census {
    /// Cells without inner grids.
    pub cells: u64,
    /// Those of them without primitives.
    pub empty_cells: u64,
    /// Cells with inner grids.
    pub dividing_cells: u64,
    pub references: u64,
}

/// The grids that a ray has traversed, where some are in several cells: a direct-mapped table on
/// the stack. It may forget (a second traversal is only a waste).
pub(crate) struct VisitedGrids([u32; Self::SLOTS]);

impl VisitedGrids {
    const SLOTS: usize = 32;

    #[inline(always)]
    pub(crate) fn new() -> Self {
        Self([u32::MAX; Self::SLOTS])
    }
}

impl Mailbox for VisitedGrids {
    const ENABLED: bool = true;

    #[inline(always)]
    fn is_new(&mut self, grid: u32) -> bool {
        std::mem::replace(&mut self.0[grid as usize % Self::SLOTS], grid) != grid
    }
}
