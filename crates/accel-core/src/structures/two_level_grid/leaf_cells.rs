//! The lower level: which resolution each upper cell gets, and the lists of its leaf cells.
//!
//! Upper cells are independent of each other, so they are divided in stretches, one for each
//! thread of the current rayon pool, of about as many references each.

use std::ops::Range;

use crate::capacity::CapacityLimits;
use crate::geometry::scalar::Scalar;
use crate::grid::block_lists::rows_in;
use crate::grid::cell_lists::CellLists;
use crate::grid::nested_grids::build::references_in;
use crate::grid::regular_grid::Contents;
use crate::grid::resolution::resolve_by_density;
use crate::grid::voxel_traversal::{CellDivision, GridFrame};
use crate::historical::bounds_rule::smallest_cell;
use crate::parallel::{map, split_mut};
use crate::structure::BuildError;

/// A leaf grid that would list its primitives more often than this on average is made coarser.
const MAX_REFS_PER_PRIM: u64 = 16;

/// How leaf grids are made.
pub(super) struct LeafRules {
    /// Leaf cells for each reference of an upper cell.
    pub density: f64,
    /// For the cells of both levels, and the references in leaf cells.
    pub room: CapacityLimits,
}

/// A cell of the upper level.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct UpperCell {
    /// Its first leaf cell; x is fastest.
    first: u32,
    /// Leaf cells per axis; 0 where it holds no primitive.
    n: [u8; 3],
}

impl UpperCell {
    /// Returns whether it holds a grid.
    #[inline(always)]
    pub fn is_divided(&self) -> bool {
        self.n.iter().any(|&n| n > 1)
    }

    /// Returns whether it holds nothing.
    pub fn is_vacant(&self) -> bool {
        self.n == [0; 3]
    }

    /// Leaf cells per axis.
    #[inline(always)]
    pub fn resolution(&self) -> [u8; 3] {
        self.n
    }

    fn leaf_cells(&self) -> usize {
        self.n.iter().map(|&n| usize::from(n)).product()
    }
}

/// The lists of all leaf cells.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct LeafCells(CellLists);

impl LeafCells {
    /// The ids in a leaf cell of `cell`.
    #[inline(always)]
    pub fn list(&self, cell: &UpperCell, leaf: usize) -> &[u32] {
        self.0.list(cell.first as usize + leaf)
    }

    /// The ids of a cell that is not divided.
    #[inline(always)]
    pub fn only_list(&self, cell: &UpperCell) -> &[u32] {
        if cell.is_vacant() { &[] } else { self.list(cell, 0) }
    }

    /// All of them, in the order of their cells.
    pub fn lists(&self) -> &CellLists {
        &self.0
    }
}

/// Divides the upper cells, whose lists are `lists`, as `division` says.
///
/// # Errors
/// [`BuildError`] where the limits do not suffice.
pub(super) fn divide<S: Scalar>(
    contents: &Contents<S>,
    division: &CellDivision<S>,
    lists: &CellLists,
    rules: &LeafRules,
) -> Result<(Vec<UpperCell>, LeafCells), BuildError> {
    let upper = UpperCellInput { contents, division, lists, rules };
    let stretches = lists.stretches(rayon::current_num_threads());
    // resolutions, then where leaf cells begin
    let resolutions: Vec<Vec<UpperCell>> =
        map(&stretches, &|cells| cells.clone().map(|cell| upper.resolution(cell)).collect());
    let mut cells = Vec::with_capacity(contents.frame.cells());
    let mut leaf_cells = 0u64;
    let mut leaves_of: Vec<usize> = Vec::with_capacity(stretches.len());
    for part in &resolutions {
        let before = leaf_cells;
        for cell in part {
            cells.push(UpperCell { first: leaf_cells as u32, ..*cell });
            leaf_cells += cell.leaf_cells() as u64;
        }
        leaves_of.push((leaf_cells - before) as usize);
    }
    let all_cells = leaf_cells + cells.len() as u64;
    rules.room.check([all_cells, 0])?;
    // counts, turned into ends that begin at 0 in each stretch
    let mut starts = vec![0u32; leaf_cells as usize + 1];
    let mut parts: Vec<CellRange> = Vec::with_capacity(stretches.len());
    for (range, counters) in stretches.iter().zip(split_mut(&mut starts, leaves_of)) {
        parts.push(CellRange { range: range.clone(), cells: &cells[range.clone()], counters });
    }
    let references = map(&mut parts, &|part| upper.count(part));
    let total: u64 = references.iter().sum();
    rules.room.check([all_cells, total])?;
    let mut ids = vec![0u32; total as usize];
    let ids_of = references.iter().map(|&n| n as usize);
    let mut before = 0;
    let mut filled: Vec<_> = Vec::with_capacity(parts.len());
    for (part, ids) in parts.into_iter().zip(split_mut(&mut ids, ids_of)) {
        let length = ids.len() as u32;
        filled.push((part, ids, before));
        before += length;
    }
    map(&mut filled, &|(part, ids, before)| upper.fill(part, ids, *before));
    if let Some(last) = starts.last_mut() {
        *last = total as u32;
    }
    Ok((cells, LeafCells(CellLists::of_parts(starts, ids))))
}

/// [`divide`] where the lists of the `changed` upper cells alone (ascending) are others than
/// before, or hold something that moved: the leaf cells of the others are copied, stretch by
/// stretch.
///
/// # Errors
/// As [`divide`].
pub(super) fn redivide<S: Scalar>(
    contents: &Contents<S>,
    division: &CellDivision<S>,
    lists: &CellLists,
    rules: &LeafRules,
    (old_cells, old): (&[UpperCell], &LeafCells),
    changed: &[u32],
) -> Result<(Vec<UpperCell>, LeafCells), BuildError> {
    let upper = UpperCellInput { contents, division, lists, rules };
    let (old_starts, old_ids) = (old.0.starts(), old.0.ids());
    let mut cells: Vec<UpperCell> = Vec::with_capacity(old_cells.len());
    let mut starts: Vec<u32> = Vec::with_capacity(old_starts.len());
    let mut ids: Vec<u32> = Vec::with_capacity(old_ids.len());
    let first_leaf =
        |cell: usize| old_cells.get(cell).map_or(old.0.cells(), |cell| cell.first as usize);
    let ends = changed.iter().map(|&cell| cell as usize).chain([old_cells.len()]);
    let mut next = 0;
    for end in ends {
        let (from, to) = (first_leaf(next), first_leaf(end));
        let at = starts.len();
        let place = |first: u32| (first as usize - from + at) as u32;
        cells
            .extend(old_cells[next..end].iter().map(|c| UpperCell { first: place(c.first), ..*c }));
        let (low, high) = (old_starts[from], old_starts[to]);
        let before = ids.len() as u32;
        starts.extend(old_starts[from..to].iter().map(|start| start - low + before));
        ids.extend_from_slice(&old_ids[low as usize..high as usize]);
        if end < old_cells.len() {
            let cell = UpperCell { first: starts.len() as u32, ..upper.resolution(end) };
            let mut counters = vec![0; cell.leaf_cells()];
            let mut part =
                CellRange { range: end..end + 1, cells: &[cell], counters: &mut counters };
            let references = upper.count(&mut part);
            let all = (starts.len() + cell.leaf_cells() + old_cells.len()) as u64;
            rules.room.check([all, ids.len() as u64 + references])?;
            let mut own = vec![0; references as usize];
            upper.fill(&mut part, &mut own, ids.len() as u32);
            cells.push(cell);
            starts.append(&mut counters);
            ids.append(&mut own);
        }
        next = end + 1;
    }
    starts.push(ids.len() as u32);
    Ok((cells, LeafCells(CellLists::of_parts(starts, ids))))
}

/// A stretch of upper cells with the counters of its leaf cells.
struct CellRange<'a> {
    range: Range<usize>,
    cells: &'a [UpperCell],
    counters: &'a mut [u32],
}

/// Input of the division of an upper cell.
struct UpperCellInput<'a, 'p, S: Scalar> {
    contents: &'a Contents<'p, S>,
    division: &'a CellDivision<S>,
    lists: &'a CellLists,
    rules: &'a LeafRules,
}

impl<S: Scalar> UpperCellInput<'_, '_, S> {
    /// The grid of an upper cell.
    fn leaf(&self, cell: usize, n: [u8; 3]) -> GridFrame<S> {
        self.division.grid(self.contents.frame.coords(cell), n)
    }

    /// The resolution of an upper cell; where its leaf cells begin is not yet known.
    fn resolution(&self, cell: usize) -> UpperCell {
        let list = self.lists.list(cell);
        let mut n = [u8::from(!list.is_empty()); 3];
        if self.rules.density * list.len() as f64 >= 2.0 {
            let bounds = self.contents.frame.cell_bounds(cell);
            let (most, smallest) =
                (self.rules.room.most_cells(), smallest_cell(self.contents.padding()));
            let wanted = resolve_by_density(bounds, list.len(), self.rules.density, most, smallest);
            n = wanted.map(|n| n.min(u32::from(u8::MAX)) as u8);
            while n != [1; 3] && !self.is_useful(cell, n, list) {
                n = n.map(|n| n.div_ceil(2));
            }
        }
        UpperCell { first: 0, n }
    }

    /// Returns whether the cells of a grid hold fewer primitives than the whole, and do not
    /// multiply them.
    fn is_useful(&self, cell: usize, n: [u8; 3], list: &[u32]) -> bool {
        let leaf = self.leaf(cell, n);
        let boxes = list.iter().map(|&id| self.contents.box_of(id));
        let references = references_in(&leaf, boxes);
        let length = list.len() as u64;
        2 * references <= length * leaf.cells() as u64 && references <= length * MAX_REFS_PER_PRIM
    }

    /// Calls `visit` with the place of each leaf cell of a stretch that primitive `id` goes to.
    #[inline(always)]
    fn leaf_cells_of(
        &self,
        leaf: &GridFrame<S>,
        first_leaf: usize,
        id: u32,
        mut visit: impl FnMut(usize),
    ) {
        rows_in(leaf.range(&self.contents.box_of(id)), |start, length| {
            let first = first_leaf + leaf.index(start);
            (first..first + length).for_each(&mut visit);
        });
    }

    /// Counts the references of each leaf cell and turns the counts into ends; returns how many
    /// there are.
    fn count(&self, part: &mut CellRange) -> u64 {
        let base = part.cells.first().map_or(0, |cell| cell.first as usize);
        for (at, cell) in part.range.clone().zip(part.cells) {
            let first_leaf = cell.first as usize - base;
            let list = self.lists.list(at);
            if !cell.is_divided() {
                if let Some(counter) = part.counters.get_mut(first_leaf)
                    && !cell.is_vacant()
                {
                    *counter = list.len() as u32;
                }
                continue;
            }
            let leaf = self.leaf(at, cell.n);
            for &id in list {
                self.leaf_cells_of(&leaf, first_leaf, id, |i| part.counters[i] += 1);
            }
        }
        let mut sum = 0u64;
        for counter in part.counters.iter_mut() {
            sum += u64::from(*counter);
            // beyond a u32 the build is refused
            *counter = sum as u32;
        }
        sum
    }

    /// Writes ids to their places and turns the ends into starts, `before` ids being those of
    /// earlier stretches.
    fn fill(&self, part: &mut CellRange, ids: &mut [u32], before: u32) {
        let base = part.cells.first().map_or(0, |cell| cell.first as usize);
        for (at, cell) in part.range.clone().zip(part.cells) {
            let list = self.lists.list(at);
            let leaf = self.leaf(at, cell.n.map(|n| n.max(1)));
            // from the back: the last id placed comes first
            for &id in list.iter().rev() {
                self.leaf_cells_of(&leaf, cell.first as usize - base, id, |i| {
                    part.counters[i] -= 1;
                    ids[part.counters[i] as usize] = id;
                });
            }
        }
        part.counters.iter_mut().for_each(|start| *start += before);
    }
}
