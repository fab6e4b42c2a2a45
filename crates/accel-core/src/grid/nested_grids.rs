//! Grids whose cells hold primitives and further grids: what HUG and the adaptive grid are made of.
//!
//! All cells of all grids stand in one array, their ids in two more. The traversal is a recursion over
//! nested grids, as deep as the builder nests them (each builder has a limit).

use std::collections::HashSet;
use std::ops::ControlFlow;
use std::sync::{Mutex, PoisonError};

use crate::geometry::aabb::Aabb;
use crate::geometry::ray::Ray;
use crate::geometry::scalar::Scalar;
use crate::grid::block_lists::{BlockPlacement, DenseRows, block_lists};
use crate::grid::box_placement::BoxPlacement;
use crate::grid::cell_lists::{CellLists, ListOrder, TooManyReferences};
use crate::grid::cell_traversal::{CellPosition, CellTraversal};
use crate::grid::voxel_traversal::GridFrame;
use crate::memory::Counted;
use crate::parallel::{forks, is_worth_a_fork, map};
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
pub(crate) fn references_in<S: Scalar>(
    frame: &GridFrame<S>,
    boxes: impl Iterator<Item = Aabb<S>>,
) -> u64 {
    boxes.map(|b| cells_in(frame.range(&b))).sum()
}

/// Cells of a block.
fn cells_in((first, last): ([i32; 3], [i32; 3])) -> u64 {
    (0..3).map(|k| (last[k] - first[k] + 1) as u64).product()
}

/// Grids over fewer primitives than this are made in memory that is used again.
const FEW: usize = 512;

/// The lists of a grid's cells, by position in `boxes`, where there are `cells` in all grids and `used`
/// references before; in place of others, if that pays.
fn lists<S: Scalar>(
    frame: GridFrame<S>,
    boxes: &[Aabb<S>],
    [cells, used]: [u64; 2],
    rules: &Rules,
    mut before: CellLists,
) -> Result<CellLists, BuildError> {
    let room = rules.room.references_beside(cells).saturating_sub(used);
    let placement = BoxPlacement { frame, boxes, by_division: rules.by_division };
    let refused = |TooManyReferences(n)| rules.room.refused([cells, n + used]);
    if boxes.len() < FEW {
        let total = (0..boxes.len() as u32).map(|i| cells_in(placement.block(i))).sum();
        if total > room {
            return Err(refused(TooManyReferences(total)));
        }
        before.rebuild(frame.cells(), boxes.len(), rules.order, &placement);
        return Ok(before);
    }
    let rows = DenseRows::new(frame.resolution());
    block_lists(&rows, boxes.len(), rules.order, room, &placement).map_err(refused)
}

/// How much there is in all grids.
#[derive(Debug, Clone, Copy, Default)]
struct Used {
    cells: u64,
    ids: u64,
    inner: u64,
}

/// Grids that are not among the others yet, so many of which were there before; `I` says what grids are in their
/// cells.
pub(crate) struct LooseGrids<S: Scalar, I> {
    grids: Vec<Grid<S>>,
    starts: Vec<CellStart>,
    ids: Vec<u32>,
    inner: Vec<I>,
    before: Used,
    /// The most references, while a grid was made.
    peak: u64,
    /// Lists whose memory is used again.
    lists: CellLists,
}

impl<S: Scalar, I> LooseGrids<S, I> {
    fn beside(before: Used) -> Self {
        let (grids, starts, ids, inner, lists) = Default::default();
        Self { grids, starts, ids, inner, before, peak: 0, lists }
    }

    /// Cells and ids of these alone.
    fn lengths(&self) -> [u64; 2] {
        [self.starts.len(), self.ids.len()].map(|n| n as u64)
    }

    /// How much is used by all, where a grid of so many cells is added.
    fn used_with(&self, cells: usize, rules: &Rules) -> Result<Used, BuildError> {
        let Self { starts, ids, inner, before, .. } = self;
        let used = Used {
            cells: before.cells + (starts.len() + cells) as u64,
            ids: before.ids + ids.len() as u64,
            inner: before.inner + inner.len() as u64,
        };
        rules.room.check([used.cells, used.ids])?;
        Ok(used)
    }

    /// Adds a grid that has so many more references while it is made; `cell` adds what is in each cell.
    fn push_cells(
        &mut self,
        frame: GridFrame<S>,
        references: usize,
        mut cell: impl FnMut(usize, &mut Vec<u32>, &mut Vec<I>),
    ) {
        self.peak = self.peak.max((self.ids.len() + references) as u64);
        self.grids.push(Grid { frame, first_cell: self.starts.len() as u32 });
        for number in 0..frame.cells() {
            cell(number, &mut self.ids, &mut self.inner);
            let [ids, grids] = [self.ids.len(), self.inner.len()].map(|n| n as u32);
            self.starts.push(CellStart { ids, grids });
        }
    }

    /// Adds a grid of which every cell may become an inner grid in place of its list: `divide` is asked with the
    /// cell's box and its list (positions in `boxes`), and answers with the inner grid.
    pub(crate) fn push_divided(
        &mut self,
        frame: GridFrame<S>,
        (ids, boxes): (&[u32], &[Aabb<S>]),
        rules: &Rules,
        divide: impl Fn(Aabb<S>, &[u32]) -> Option<I> + Sync,
    ) -> Result<(), BuildError>
    where
        I: Send,
    {
        let used = self.used_with(frame.cells(), rules)?;
        let memory = std::mem::take(&mut self.lists);
        let lists = lists(frame, boxes, [used.cells, used.ids], rules, memory)?;
        let grid_in = |cell: &usize| divide(frame.cell_bounds(*cell), lists.list(*cell));
        let pays = is_worth_a_fork(lists.references()) && forks() > 0;
        let mut inner_grids = pays.then(|| {
            let all: Vec<usize> = (0..frame.cells()).collect();
            map(&all, &grid_in).into_iter()
        });
        self.push_cells(frame, lists.references(), |cell, own, inner| {
            let grid = match &mut inner_grids {
                Some(all) => all.next().flatten(),
                None => grid_in(&cell),
            };
            match grid {
                Some(grid) => inner.push(grid),
                None => own.extend(lists.list(cell).iter().map(|&i| ids[i as usize])),
            }
        });
        self.lists = lists;
        Ok(())
    }
}

impl<S: Scalar> LooseGrids<S, u32> {
    /// Adds a grid with the primitives `ids` and the grids `inner`, each with its box at the same position; inner
    /// grids may be added later.
    pub(crate) fn push(
        &mut self,
        frame: GridFrame<S>,
        (ids, id_boxes): (&[u32], &[Aabb<S>]),
        (inner, inner_boxes): (&[u32], &[Aabb<S>]),
        rules: &Rules,
    ) -> Result<(), BuildError> {
        let used = self.used_with(frame.cells(), rules)?;
        let memory = CellLists::default;
        let id_lists = lists(frame, id_boxes, [used.cells, used.ids], rules, memory())?;
        let inner_lists = match inner {
            [] => memory(),
            _ => lists(frame, inner_boxes, [used.cells, used.inner], rules, memory())?,
        };
        self.push_cells(frame, id_lists.references(), |cell, own, grids| {
            own.extend(id_lists.list(cell).iter().map(|&i| ids[i as usize]));
            grids.extend(inner_lists.list(cell).iter().map(|&i| inner[i as usize]));
        });
        Ok(())
    }
}

/// So many grids at most are made by one thread before they stand among the others.
const AT_A_TIME: usize = 64;

impl<S: Scalar> NestedGrids<S> {
    pub(crate) fn new() -> Self {
        let starts = vec![CellStart { ids: 0, grids: 0 }];
        Self { grids: Vec::new(), starts, ids: Vec::new(), inner: Vec::new() }
    }

    /// The references of all cells.
    pub(crate) fn lists(&self) -> impl Iterator<Item = &[u32]> {
        self.starts.windows(2).filter_map(|at| self.ids.get(at[0].ids as usize..at[1].ids as usize))
    }

    /// Adds the grid that `push` makes of each item, in their order, on all threads; `number` gives the grids in its
    /// cells their numbers. The number of a grid is its place.
    ///
    /// # Errors
    /// The first that `push` has.
    pub(crate) fn push_all<T: Sync, I: Send>(
        &mut self,
        items: &[T],
        rules: &Rules,
        push: impl Fn(&mut LooseGrids<S, I>, &T) -> Result<(), BuildError> + Sync,
        number: &mut dyn FnMut(I) -> u32,
    ) -> Result<(), BuildError> {
        let parts_at_once = 1 << forks();
        let size = items.len().div_ceil(parts_at_once).clamp(1, AT_A_TIME);
        let parts: Vec<&[T]> = items.chunks(size).collect();
        for parts in parts.chunks(parts_at_once) {
            let (before, all) = (self.used(), Mutex::new([0; 2]));
            // what is made at once takes no more room, but for a grid a thread, than all have
            let made_at_once = |part: &&[T]| -> Result<LooseGrids<S, I>, BuildError> {
                let mut grids = LooseGrids::beside(before);
                for item in *part {
                    let [cells, ids] = grids.lengths();
                    push(&mut grids, item)?;
                    let mut all = all.lock().unwrap_or_else(PoisonError::into_inner);
                    let [more_cells, more_ids] = grids.lengths();
                    *all = [all[0] + more_cells - cells, all[1] + more_ids - ids];
                    rules.room.check([before.cells + all[0], before.ids + all[1]])?;
                }
                Ok(grids)
            };
            for (part, grids) in parts.iter().zip(map(parts, &made_at_once)) {
                let fits = grids.ok().filter(|grids| self.has_room_for(grids, rules));
                // what is refused is said as one thread would say it
                let one_by_one = || {
                    let mut grids = LooseGrids::beside(self.used());
                    part.iter().try_for_each(|item| push(&mut grids, item)).map(|()| grids)
                };
                let grids = fits.map_or_else(one_by_one, Ok)?;
                self.append(grids, number);
            }
        }
        Ok(())
    }

    fn used(&self) -> Used {
        let [cells, ids, inner] =
            [self.starts.len() - 1, self.ids.len(), self.inner.len()].map(|n| n as u64);
        Used { cells, ids, inner }
    }

    /// Whether these would have been made with what is used now before them.
    fn has_room_for<I>(&self, grids: &LooseGrids<S, I>, rules: &Rules) -> bool {
        let used = self.used();
        let references = (used.ids + grids.peak).max(used.inner + grids.inner.len() as u64);
        rules.room.check([used.cells + grids.starts.len() as u64, references]).is_ok()
    }

    fn append<I>(&mut self, grids: LooseGrids<S, I>, number: &mut dyn FnMut(I) -> u32) {
        let [cells, ids, inner] =
            [self.starts.len() - 1, self.ids.len(), self.inner.len()].map(|n| n as u32);
        let moved = |grid: Grid<S>| Grid { first_cell: cells + grid.first_cell, ..grid };
        self.grids.extend(grids.grids.into_iter().map(moved));
        let moved = |at: CellStart| CellStart { ids: ids + at.ids, grids: inner + at.grids };
        self.starts.extend(grids.starts.into_iter().map(moved));
        self.ids.extend_from_slice(&grids.ids);
        self.inner.extend(grids.inner.into_iter().map(number));
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
