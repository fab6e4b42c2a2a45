//! How nested grids are made: some at a time by each thread, put together in order.

use std::sync::{Mutex, PoisonError};

use super::{CellStart, Grid, NestedGrids};
use crate::capacity::CapacityLimits;
use crate::geometry::aabb::Aabb;
use crate::geometry::scalar::Scalar;
use crate::grid::block_lists::{BlockPlacement, BoxPlacement, DenseRows, block_lists, cells_in};
use crate::grid::cell_lists::{CellLists, ListOrder, TooManyReferences};
use crate::grid::voxel_traversal::GridFrame;
use crate::memory::{CountedItem, Limits};
use crate::parallel::{forks, map, should_parallelize};
use crate::structure::BuildError;

/// Limits and conventions of a build.
#[derive(Debug, Clone, Copy)]
pub(crate) struct BuildRules {
    /// Cells by division, and ids in them in descending order, as in 1999.
    pub historical: bool,
    /// For the cells of all grids, and the references in them.
    pub room: CapacityLimits,
}

/// Voxels of nested grids: where the ids and the grids of each begin.
static VOXELS: CountedItem = CountedItem::cells("number of voxels", 8);
static REFERENCES: CountedItem = CountedItem::references("references in voxels");

/// Room for so many voxels and references at most.
pub(crate) fn room_of(limits: Limits, max_cells: u64, max_references: u64) -> CapacityLimits {
    CapacityLimits::new(limits, [(&VOXELS, max_cells), (&REFERENCES, max_references)])
}

/// References that boxes would have in a grid; counted without visiting cells.
pub(crate) fn references_in<S: Scalar>(
    frame: &GridFrame<S>,
    boxes: impl Iterator<Item = Aabb<S>>,
) -> u64 {
    boxes.map(|b| cells_in(frame.range(&b))).sum()
}

/// Grids over fewer primitives than this are made in memory that is used again.
const FEW: usize = 512;

/// The lists of a grid's cells, by position in `boxes`, where there are `cells` in all grids and
/// `used` references before; in place of others, if that pays.
fn lists<S: Scalar>(
    frame: GridFrame<S>,
    boxes: &[Aabb<S>],
    [cells, used]: [u64; 2],
    rules: &BuildRules,
    mut before: CellLists,
) -> Result<CellLists, BuildError> {
    let room = rules.room.references_beside(cells).saturating_sub(used);
    let placement = BoxPlacement { frame, boxes, by_division: rules.historical };
    let order = if rules.historical { ListOrder::Reverse } else { ListOrder::File };
    let refused = |TooManyReferences(n)| rules.room.refused([cells, n + used]);
    if boxes.len() < FEW {
        let total = (0..boxes.len() as u32).map(|i| cells_in(placement.block(i))).sum();
        if total > room {
            return Err(refused(TooManyReferences(total)));
        }
        before.rebuild(frame.cells(), boxes.len(), order, &placement);
        return Ok(before);
    }
    let rows = DenseRows::new(frame.resolution());
    block_lists(&rows, boxes.len(), order, room, &placement).map_err(refused)
}

/// Totals over all grids.
#[derive(Debug, Clone, Copy, Default)]
struct GridTotals {
    cells: u64,
    ids: u64,
    inner: u64,
}

/// Grids that are not among the others yet, so many of which were there before; `I` says what grids
/// are in their cells.
pub(crate) struct LooseGrids<S: Scalar, I> {
    made: NestedGrids<S, I>,
    before: GridTotals,
    /// The most references, while a grid was made.
    peak: u64,
    /// Lists whose memory is used again.
    lists: CellLists,
}

impl<S: Scalar, I> LooseGrids<S, I> {
    fn beside(before: GridTotals) -> Self {
        Self { made: NestedGrids::new(), before, peak: 0, lists: CellLists::default() }
    }

    /// Totals after adding a grid of this many cells.
    fn used_with(&self, cells: usize, rules: &BuildRules) -> Result<GridTotals, BuildError> {
        let (own, before) = (self.made.used(), self.before);
        let used = GridTotals {
            cells: before.cells + own.cells + cells as u64,
            ids: before.ids + own.ids,
            inner: before.inner + own.inner,
        };
        rules.room.check([used.cells, used.ids])?;
        Ok(used)
    }

    /// Adds a grid that has so many more references while it is made; `cell` adds what is in each
    /// cell.
    fn push_cells(
        &mut self,
        frame: GridFrame<S>,
        references: usize,
        mut cell: impl FnMut(usize, &mut Vec<u32>, &mut Vec<I>),
    ) {
        let NestedGrids { grids, starts, ids, inner } = &mut self.made;
        self.peak = self.peak.max((ids.len() + references) as u64);
        grids.push(Grid { frame, first_cell: starts.len() as u32 - 1 });
        for number in 0..frame.cells() {
            cell(number, ids, inner);
            starts.push(CellStart { ids: ids.len() as u32, grids: inner.len() as u32 });
        }
    }

    /// Adds a grid of which every cell may become an inner grid in place of its list: `divide` is
    /// asked with the cell's box and its list (positions in `boxes`), and answers with the inner
    /// grid.
    pub(crate) fn push_divided(
        &mut self,
        frame: GridFrame<S>,
        (ids, boxes): (&[u32], &[Aabb<S>]),
        rules: &BuildRules,
        divide: impl Fn(Aabb<S>, &[u32]) -> Option<I> + Sync,
    ) -> Result<(), BuildError>
    where
        I: Send,
    {
        let used = self.used_with(frame.cells(), rules)?;
        let memory = std::mem::take(&mut self.lists);
        let lists = lists(frame, boxes, [used.cells, used.ids], rules, memory)?;
        let grid_in = |cell: &usize| divide(frame.cell_bounds(*cell), lists.list(*cell));
        let mut inner_grids = should_parallelize(lists.references()).then(|| {
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
    /// Adds a grid with the primitives `ids` and the grids `inner`, each with its box at the same
    /// position; inner grids may be added later.
    pub(crate) fn push(
        &mut self,
        frame: GridFrame<S>,
        (ids, id_boxes): (&[u32], &[Aabb<S>]),
        (inner, inner_boxes): (&[u32], &[Aabb<S>]),
        rules: &BuildRules,
    ) -> Result<(), BuildError> {
        let used = self.used_with(frame.cells(), rules)?;
        let id_lists = lists(frame, id_boxes, [used.cells, used.ids], rules, CellLists::default())?;
        let inner_lists = match inner {
            [] => CellLists::default(),
            _ => lists(frame, inner_boxes, [used.cells, used.inner], rules, CellLists::default())?,
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

impl<S: Scalar, I> NestedGrids<S, I> {
    pub(crate) fn new() -> Self {
        let starts = vec![CellStart { ids: 0, grids: 0 }];
        Self { grids: Vec::new(), starts, ids: Vec::new(), inner: Vec::new() }
    }

    fn used(&self) -> GridTotals {
        let [cells, ids, inner] =
            [self.starts.len() - 1, self.ids.len(), self.inner.len()].map(|n| n as u64);
        GridTotals { cells, ids, inner }
    }
}

impl<S: Scalar> NestedGrids<S> {
    /// Adds the grid that `push` makes of each item, in their order, on all threads; `number` gives
    /// the grids in its cells their numbers. The number of a grid is its place.
    ///
    /// # Errors
    /// The first that `push` has.
    pub(crate) fn push_all<T: Sync, I: Send>(
        &mut self,
        items: &[T],
        rules: &BuildRules,
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
                    let own = grids.made.used();
                    push(&mut grids, item)?;
                    let mut all = all.lock().unwrap_or_else(PoisonError::into_inner);
                    let more = grids.made.used();
                    *all = [all[0] + more.cells - own.cells, all[1] + more.ids - own.ids];
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
                self.append(grids.made, number);
            }
        }
        Ok(())
    }

    /// Returns whether these grids would also have been built after those that exist now.
    fn has_room_for<I>(&self, grids: &LooseGrids<S, I>, rules: &BuildRules) -> bool {
        let (used, own) = (self.used(), grids.made.used());
        let references = (used.ids + grids.peak).max(used.inner + own.inner);
        rules.room.check([used.cells + own.cells, references]).is_ok()
    }

    fn append<I>(&mut self, grids: NestedGrids<S, I>, number: &mut dyn FnMut(I) -> u32) {
        let GridTotals { cells, ids, inner } = self.used();
        let moved = |grid: Grid<S>| Grid { first_cell: cells as u32 + grid.first_cell, ..grid };
        self.grids.extend(grids.grids.into_iter().map(moved));
        let moved =
            |at: CellStart| CellStart { ids: ids as u32 + at.ids, grids: inner as u32 + at.grids };
        self.starts.extend(grids.starts.into_iter().skip(1).map(moved));
        self.ids.extend_from_slice(&grids.ids);
        self.inner.extend(grids.inner.into_iter().map(number));
    }
}
