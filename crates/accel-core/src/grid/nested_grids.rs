//! Grids whose cells hold primitives and further grids: what HUG and the adaptive grid are made of.
//!
//! All cells of all grids stand in one array, their ids in two more. The traversal is a recursion over
//! nested grids, as deep as the builder nests them (each builder has a limit).

use std::collections::HashSet;
use std::ops::ControlFlow;

use crate::geometry::aabb::Aabb;
use crate::geometry::ray::Ray;
use crate::geometry::scalar::Scalar;
use crate::grid::block_lists::{DenseRows, block_lists};
use crate::grid::box_placement::BoxPlacement;
use crate::grid::cell_lists::{CellLists, ListOrder, TooManyReferences};
use crate::grid::cell_traversal::{CellPosition, CellTraversal};
use crate::grid::voxel_traversal::GridFrame;
use crate::memory::Counted;
use crate::query::cells::{Cell, CellKind, CellVisitor};
use crate::query::sink::Sink;
use crate::room::Room;
use crate::structure::BuildError;

/// Limits and conventions of a build.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Rules {
    /// Order of ids in a cell.
    pub order: ListOrder,
    /// Cells by division, as in 1999.
    pub by_division: bool,
    /// For the cells of all grids, and the references in them.
    pub room: Room,
}

/// Voxels of nested grids: where the ids and the grids of each begin.
pub(crate) static VOXELS: Counted = Counted::cells("number of voxels", 8);
/// Ids in them.
pub(crate) static REFERENCES: Counted = Counted::references("references in voxels");

#[derive(Debug, Clone, Copy)]
struct Grid<S: Scalar> {
    frame: GridFrame<S>,
    first_cell: u32,
}

/// Where the lists of a cell begin; they end where those of the next cell begin.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct CellStart {
    ids: u32,
    grids: u32,
}

/// The grids. Number 0 is the first one pushed.
pub(crate) struct NestedGrids<S: Scalar> {
    grids: Vec<Grid<S>>,
    /// One more than there are cells.
    starts: Vec<CellStart>,
    ids: Vec<u32>,
    inner: Vec<u32>,
}

/// References that boxes would have in a grid; counted without visiting cells.
pub(crate) fn references_in<S: Scalar>(frame: &GridFrame<S>, boxes: &[Aabb<S>]) -> u64 {
    boxes
        .iter()
        .map(|b| {
            let (first, last) = frame.range(b);
            (0..3).map(|k| (last[k] - first[k] + 1) as u64).product::<u64>()
        })
        .sum()
}

/// The lists of a grid's cells, by position in `boxes`, where there are `cells` in all grids and `used`
/// references before.
fn lists<S: Scalar>(
    frame: GridFrame<S>,
    boxes: &[Aabb<S>],
    [cells, used]: [u64; 2],
    rules: &Rules,
) -> Result<CellLists, BuildError> {
    let rows = DenseRows::new(frame.resolution());
    let room = rules.room.references_beside(cells).saturating_sub(used);
    let placement = BoxPlacement { frame, boxes, by_division: rules.by_division };
    block_lists(&rows, boxes.len(), rules.order, room, &placement)
        .map_err(|TooManyReferences(n)| rules.room.refused([cells, n + used]))
}

impl<S: Scalar> NestedGrids<S> {
    pub(crate) fn new() -> Self {
        let starts = vec![CellStart { ids: 0, grids: 0 }];
        Self { grids: Vec::new(), starts, ids: Vec::new(), inner: Vec::new() }
    }

    /// The references of all cells.
    pub(crate) fn lists(&self) -> impl Iterator<Item = &[u32]> {
        self.starts.windows(2).filter_map(|at| self.ids.get(at[0].ids as usize..at[1].ids as usize))
    }

    /// Adds a grid with the primitives `ids` and the grids `inner`, each with its box at the same
    /// position, and returns its number. Inner grids may be pushed later.
    pub(crate) fn push(
        &mut self,
        frame: GridFrame<S>,
        (ids, id_boxes): (&[u32], &[Aabb<S>]),
        (inner, inner_boxes): (&[u32], &[Aabb<S>]),
        rules: &Rules,
    ) -> Result<u32, BuildError> {
        let cells = (self.starts.len() - 1 + frame.cells()) as u64;
        rules.room.check([cells, self.ids.len() as u64])?;
        let id_lists = lists(frame, id_boxes, [cells, self.ids.len() as u64], rules)?;
        let inner_lists = match inner {
            [] => CellLists::default(),
            _ => lists(frame, inner_boxes, [cells, self.inner.len() as u64], rules)?,
        };
        let number = self.grids.len() as u32;
        self.grids.push(Grid { frame, first_cell: (self.starts.len() - 1) as u32 });
        for cell in 0..frame.cells() {
            self.ids.extend(id_lists.list(cell).iter().map(|&i| ids[i as usize]));
            self.inner.extend(inner_lists.list(cell).iter().map(|&i| inner[i as usize]));
            self.starts
                .push(CellStart { ids: self.ids.len() as u32, grids: self.inner.len() as u32 });
        }
        Ok(number)
    }

    /// Adds a grid of which every cell may become an inner grid in place of its list: `divide` is
    /// asked with the cell's box and its list (positions in `boxes`), and answers with the inner
    /// grid's number.
    pub(crate) fn push_divided(
        &mut self,
        frame: GridFrame<S>,
        (ids, boxes): (&[u32], &[Aabb<S>]),
        rules: &Rules,
        mut divide: impl FnMut(Aabb<S>, &[u32]) -> Option<u32>,
    ) -> Result<u32, BuildError> {
        let cells = (self.starts.len() - 1 + frame.cells()) as u64;
        let used = self.ids.len() as u64;
        rules.room.check([cells, used])?;
        let lists = lists(frame, boxes, [cells, used], rules)?;
        let number = self.grids.len() as u32;
        self.grids.push(Grid { frame, first_cell: (self.starts.len() - 1) as u32 });
        for cell in 0..frame.cells() {
            let list = lists.list(cell);
            match divide(frame.cell_bounds(cell), list) {
                Some(grid) => self.inner.push(grid),
                None => self.ids.extend(list.iter().map(|&i| ids[i as usize])),
            }
            self.starts
                .push(CellStart { ids: self.ids.len() as u32, grids: self.inner.len() as u32 });
        }
        Ok(number)
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

    /// Calls `each` with the cells of a grid, and with those of the grids within that are not in `seen`: as
    /// cells within a cell or, where none is in two cells (`are_unique`), with the grids in place of the
    /// cells that hold them.
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

    /// What a grid divides.
    pub(crate) fn bounds(&self, grid: u32) -> Aabb<S> {
        self.grids.get(grid as usize).map_or(Aabb::empty(), |grid| grid.frame.bounds())
    }

    /// True when the ray meets the box of a grid.
    pub(crate) fn meets(&self, grid: u32, ray: &Ray<S>, t_start: S) -> bool {
        self.bounds(grid).clip(ray.origin, ray.direction, t_start, ray.t_max).is_some()
    }

    /// Bytes occupied.
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
        visited: &mut impl Visited,
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
                    if visited.is_first(inner) {
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

/// What [`NestedGrids::census`] counts.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct Census {
    /// Cells without inner grids.
    pub cells: u64,
    /// Those of them without primitives.
    pub empty_cells: u64,
    /// Cells with inner grids.
    pub dividing_cells: u64,
    /// References to primitives.
    pub references: u64,
}

/// Remembers which grids a ray has traversed. It may forget (a second traversal is only a waste), but
/// never claims a traversal that was not made.
pub(crate) trait Visited {
    /// True unless the grid is known to have been traversed; remembers it.
    fn is_first(&mut self, grid: u32) -> bool;
}

/// For grids of which none is in two cells.
pub(crate) struct NoMailbox;

impl Visited for NoMailbox {
    #[inline(always)]
    fn is_first(&mut self, _: u32) -> bool {
        true
    }
}

/// A direct-mapped table on the stack.
pub(crate) struct Mailbox([u32; Self::SLOTS]);

impl Mailbox {
    const SLOTS: usize = 32;

    #[inline(always)]
    pub(crate) fn new() -> Self {
        Self([u32::MAX; Self::SLOTS])
    }
}

impl Visited for Mailbox {
    #[inline(always)]
    fn is_first(&mut self, grid: u32) -> bool {
        std::mem::replace(&mut self.0[grid as usize % Self::SLOTS], grid) != grid
    }
}
