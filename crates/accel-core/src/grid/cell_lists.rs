//! Lists of primitive ids per cell in one array: count, prefix sum, fill (compressed rows).
//!
//! Built here for any placement of primitives; where each goes to a block of cells of a dense grid,
//! `block_lists.rs` is faster.

use std::ops::{Deref, Range};
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};

use crate::grid::sort_in_parts::{Counts, filled, filled_whole, turn_into_ends, useful_parts};
use crate::parallel::map;
use crate::structure::StructureStats;

/// For every cell, the slice of ids it holds; in an array of its own, or in one shared with other
/// lists.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct CellLists<I = Vec<u32>> {
    /// `ids[starts[c]..starts[c + 1]]` belongs to cell `c`.
    starts: Vec<u32>,
    ids: I,
}

/// The order of ids within a cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ListOrder {
    File,
    /// Descending ids, as Havran and Sixta's uniform grid had them.
    Reverse,
}

/// More references than a `u32` can count.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TooManyReferences(pub u64);

/// Says which cells a primitive goes to.
pub trait Placement: Sync {
    /// Calls `emit` with every cell primitive `id` goes to; the same ones each time it is asked.
    fn cells_of(&self, id: u32, emit: impl FnMut(usize));
}

/// How many of these ids go to each cell, and to all; counting ends once these are more than
/// `most`.
#[inline(always)]
fn count(
    cells: usize,
    ids: impl Iterator<Item = u32>,
    most: u64,
    placement: &impl Placement,
) -> Counts {
    let mut counts = Vec::new();
    let total = count_in(&mut counts, cells, ids, most, placement);
    (counts, total)
}

/// The same into counts that are used again.
#[inline(always)]
fn count_in(
    counts: &mut Vec<u32>,
    cells: usize,
    ids: impl Iterator<Item = u32>,
    most: u64,
    placement: &impl Placement,
) -> u64 {
    counts.clear();
    counts.resize(cells + 1, 0);
    let mut total = 0u64;
    for id in ids {
        placement.cells_of(id, |cell| {
            counts[cell] = counts[cell].wrapping_add(1);
            total += 1;
        });
        if total > most {
            break;
        }
    }
    total
}

/// Puts these ids to their places: each cursor goes down from the end of a list.
#[inline(always)]
fn fill(
    ids: impl DoubleEndedIterator<Item = u32>,
    order: ListOrder,
    placement: &impl Placement,
    cursors: &mut [u32],
    mut put: impl FnMut(usize, u32),
) {
    let mut place = |id: u32| {
        placement.cells_of(id, |cell| {
            cursors[cell] -= 1;
            put(cursors[cell] as usize, id);
        });
    };
    // from the back: the last id placed comes first
    match order {
        ListOrder::File => ids.rev().for_each(&mut place),
        ListOrder::Reverse => ids.for_each(&mut place),
    }
}

impl CellLists {
    /// Builds the lists of `cells` cells for primitives `0..primitives`.
    ///
    /// # Errors
    /// [`TooManyReferences`] when the references exceed `max_references`; nothing is allocated
    /// for them then.
    pub fn build(
        cells: usize,
        primitives: usize,
        order: ListOrder,
        max_references: u64,
        placement: &impl Placement,
    ) -> Result<Self, TooManyReferences> {
        let parts = useful_parts(primitives, cells);
        let ids = |part: Range<usize>| part.start as u32..part.end as u32;
        let counted = map(&parts, &|part| count(cells, ids(part.clone()), u64::MAX, placement));
        let fill = |part: Range<usize>, cursors: &mut [u32], numbers: &[AtomicU32]| {
            let put = |at: usize, id| numbers[at].store(id, Ordering::Relaxed);
            fill(ids(part), order, placement, cursors, put);
        };
        filled(counted, parts, order == ListOrder::Reverse, max_references, &fill)
            .map(|(starts, ids)| Self { starts, ids })
            .map_err(TooManyReferences)
    }

    /// Builds the lists of `cells` cells for these primitives, each list in the order of `ids`.
    ///
    /// # Errors
    /// As [`CellLists::build`], but counting ends where the limit is passed.
    pub fn build_of(
        cells: usize,
        ids: &[u32],
        max_references: u64,
        placement: &impl Placement,
    ) -> Result<Self, TooManyReferences> {
        let ids = ids.iter().copied();
        let counted = count(cells, ids.clone(), max_references, placement);
        let fill = |cursors: &mut [u32], numbers: &mut [u32]| {
            fill(ids, ListOrder::File, placement, cursors, |at, id| numbers[at] = id);
        };
        filled_whole(counted, max_references, fill)
            .map(|(starts, ids)| Self { starts, ids })
            .map_err(TooManyReferences)
    }

    /// The lists of [`CellLists::build`] in the memory of those before, by one thread, where there
    /// are no more references than may be.
    pub(crate) fn rebuild(
        &mut self,
        cells: usize,
        primitives: usize,
        order: ListOrder,
        placement: &impl Placement,
    ) {
        let all = 0..primitives as u32;
        let total = count_in(&mut self.starts, cells, all.clone(), u64::MAX, placement);
        turn_into_ends(&mut self.starts);
        self.ids.resize(total as usize, 0);
        let ids = &mut self.ids;
        fill(all, order, placement, &mut self.starts, |at, id| ids[at] = id);
    }

    /// The lists of these pairs of a cell and an id, ids in their order.
    pub(crate) fn of_pairs<'a>(
        cells: usize,
        pairs: impl DoubleEndedIterator<Item = &'a (u32, u32)> + Clone,
    ) -> Self {
        let mut starts = vec![0; cells + 1];
        pairs.clone().for_each(|&(cell, _)| starts[cell as usize] += 1);
        turn_into_ends(&mut starts);
        let mut ids = vec![0; starts[cells] as usize];
        for &(cell, id) in pairs.rev() {
            let at = &mut starts[cell as usize];
            *at -= 1;
            ids[*at as usize] = id;
        }
        Self { starts, ids }
    }

    /// From starts, one more than there are cells, and ids.
    pub(crate) fn of_parts(starts: Vec<u32>, ids: Vec<u32>) -> Self {
        Self { starts, ids }
    }

    /// Lists of no cell yet.
    pub(crate) fn none() -> Self {
        Self { starts: vec![0], ids: Vec::new() }
    }

    /// Adds the list of another cell.
    pub(crate) fn push(&mut self, ids: &[u32]) {
        self.ids.extend_from_slice(ids);
        self.starts.push(self.ids.len() as u32);
    }

    /// The ids of a cell that exists.
    #[inline(always)]
    pub(crate) fn at(&self, cell: usize) -> &[u32] {
        &self.ids[self.starts[cell] as usize..self.starts[cell + 1] as usize]
    }

    pub(crate) fn starts(&self) -> &[u32] {
        &self.starts
    }

    pub(crate) fn ids(&self) -> &[u32] {
        &self.ids
    }

    /// Asks `replacement` for every list that is not empty; where it answers, the list becomes
    /// that one entry.
    ///
    /// # Errors
    /// The first error of `replacement`.
    pub fn replaced<E>(
        mut self,
        mut replacement: impl FnMut(usize, &[u32]) -> Result<Option<u32>, E>,
    ) -> Result<Self, E> {
        let mut end = 0;
        for cell in 0..self.cells() {
            // entries only move down: what is still to be read is never overwritten
            let (from, to) = (self.starts[cell] as usize, self.starts[cell + 1] as usize);
            self.starts[cell] = end as u32;
            let answer = if from < to { replacement(cell, &self.ids[from..to])? } else { None };
            if let Some(entry) = answer {
                self.ids[end] = entry;
                end += 1;
            } else {
                self.ids.copy_within(from..to, end);
                end += to - from;
            }
        }
        if let Some(last) = self.starts.last_mut() {
            *last = end as u32;
        }
        if end < self.ids.len() {
            self.ids.truncate(end);
            self.ids.shrink_to_fit();
        }
        Ok(self)
    }

    /// Cuts the cells into stretches of about as many ids each: at most `most`, at least one, none
    /// of few ids.
    pub fn stretches(&self, most: usize) -> Vec<Range<usize>> {
        const LEAST_IDS: usize = 4096;
        let parts = most.min(self.ids.len() / LEAST_IDS).max(1);
        let end_of = |part: usize| {
            if part == parts {
                self.cells()
            } else {
                let ids = (self.ids.len() as u64 * part as u64 / parts as u64) as u32;
                self.starts.partition_point(|&start| start < ids).min(self.cells())
            }
        };
        (0..parts).map(|part| if part == 0 { 0 } else { end_of(part) }..end_of(part + 1)).collect()
    }

    /// Starts (one more than cells) and ids, for a storage of another layout.
    pub fn into_parts(self) -> (Vec<u32>, Vec<u32>) {
        (self.starts, self.ids)
    }
}

impl<I: Deref<Target = [u32]>> CellLists<I> {
    /// The ids of a cell; empty for a cell that does not exist.
    #[inline(always)]
    pub fn list(&self, cell: usize) -> &[u32] {
        match self.starts.get(cell..cell + 2) {
            Some(&[a, b]) => self.ids.get(a as usize..b as usize).unwrap_or(&[]),
            _ => &[],
        }
    }

    pub fn lists(&self) -> impl Iterator<Item = &[u32]> {
        self.starts.windows(2).map(|at| &self.ids[at[0] as usize..at[1] as usize])
    }

    pub fn cells(&self) -> usize {
        self.starts.len().saturating_sub(1)
    }

    /// Number of cells without ids.
    pub fn empty_cells(&self) -> usize {
        self.starts.windows(2).filter(|w| w[0] == w[1]).count()
    }

    /// Number of ids in all cells together.
    pub fn references(&self) -> usize {
        match (self.starts.first(), self.starts.last()) {
            (Some(&first), Some(&last)) => (last - first) as usize,
            _ => 0,
        }
    }

    pub fn bytes(&self) -> usize {
        (self.starts.len() + self.references()) * 4
    }
}

impl CellLists {
    /// Their cells, references and bytes.
    pub(crate) fn stats(&self) -> StructureStats {
        StructureStats {
            cells: self.cells() as u64,
            empty_cells: self.empty_cells() as u64,
            references: self.references() as u64,
            bytes: self.bytes() as u64,
            ..StructureStats::default()
        }
    }
}

impl From<CellLists> for CellLists<Arc<[u32]>> {
    fn from(CellLists { starts, ids }: CellLists) -> Self {
        Self { starts, ids: ids.into() }
    }
}

impl CellLists<Arc<[u32]>> {
    /// Moves ids that are these lists' alone to the end of an array that is to be shared; the lists
    /// have none until it [is](Self::share). Nothing is changed where the array has no room for
    /// them.
    pub(crate) fn move_to(&mut self, all: &mut Vec<u32>) {
        let base = u32::try_from(all.len()).ok();
        if let Some(base) = base.filter(|b| b.checked_add(self.ids.len() as u32).is_some()) {
            all.extend_from_slice(&self.ids);
            self.starts.iter_mut().for_each(|start| *start += base);
            self.ids = Arc::default();
        }
    }

    /// Takes the array that ids were moved to.
    pub(crate) fn share(&mut self, all: &Arc<[u32]>) {
        if self.ids.is_empty() {
            self.ids = Arc::clone(all);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::structures::test_scenes::on_threads;

    /// Primitive i goes to cells i % 4 and 2.
    struct TwoCellsEach;

    impl Placement for TwoCellsEach {
        fn cells_of(&self, id: u32, mut emit: impl FnMut(usize)) {
            emit(id as usize % 4);
            emit(2);
        }
    }

    fn build(order: ListOrder, max: u64) -> Result<CellLists, TooManyReferences> {
        CellLists::build(5, 6, order, max, &TwoCellsEach)
    }

    #[test]
    fn every_reference_in_the_order_asked_for() {
        let lists = build(ListOrder::File, 99).unwrap();
        assert_eq!(lists.list(0), [0, 4]);
        assert_eq!(lists.list(1), [1, 5]);
        assert_eq!(lists.list(2), [0, 1, 2, 2, 3, 4, 5]);
        assert_eq!(lists.list(4), [0u32; 0]);
        assert_eq!(lists.list(99), [0u32; 0]);
        assert_eq!((lists.cells(), lists.empty_cells(), lists.references()), (5, 1, 12));
        let reverse = build(ListOrder::Reverse, 99).unwrap();
        assert_eq!(reverse.list(2), [5, 4, 3, 2, 2, 1, 0]);
    }

    #[test]
    fn any_number_of_threads_makes_the_lists_that_one_cell_after_the_other_has() {
        struct ScatteredItems;
        impl Placement for ScatteredItems {
            fn cells_of(&self, id: u32, mut emit: impl FnMut(usize)) {
                let hash = id.wrapping_mul(0x9E37_79B9);
                (0..1 + id % 5).for_each(|k| emit((hash >> k) as usize % 700));
            }
        }
        let (cells, primitives) = (700, 30_000);
        let mut expected = vec![Vec::new(); cells];
        for id in 0..primitives as u32 {
            ScatteredItems.cells_of(id, |cell| expected[cell].push(id));
        }
        for order in [ListOrder::File, ListOrder::Reverse] {
            for threads in [1, 2, 5] {
                let build = |max| {
                    let build = || CellLists::build(cells, primitives, order, max, &ScatteredItems);
                    on_threads(threads, build)
                };
                let lists = build(u64::MAX).unwrap();
                let right = lists.lists().eq(expected.iter().map(Vec::as_slice));
                assert!(right, "{threads} {order:?}");
                assert_eq!(build(89_999), Err(TooManyReferences(90_000)));
            }
            expected.iter_mut().for_each(|list| list.reverse());
        }
    }

    #[test]
    fn lists_of_some_primitives_and_replaced_lists() {
        let lists = CellLists::build_of(5, &[5, 1, 4], 99, &TwoCellsEach).unwrap();
        assert_eq!((lists.list(2), lists.list(1)), (&[5, 1, 4][..], &[5, 1][..]));
        let mut asked = Vec::new();
        let lists = build(ListOrder::File, 99)
            .unwrap()
            .replaced(|cell, list| {
                asked.push(cell);
                Ok::<_, ()>((list.len() > 2).then_some(77))
            })
            .unwrap();
        assert_eq!(asked, [0, 1, 2, 3]);
        assert!(lists.lists().eq([&[0, 4][..], &[1, 5], &[77], &[3], &[]]));
        assert_eq!(lists.references(), 6);
        assert_eq!(lists.replaced(|_, _| Err("no")), Err("no"));
    }

    #[test]
    fn stretches_share_the_ids_out() {
        struct OneCellForAll;
        impl Placement for OneCellForAll {
            fn cells_of(&self, id: u32, mut emit: impl FnMut(usize)) {
                emit(if id < 20_000 { 3 } else { id as usize % 100 });
            }
        }
        let lists =
            CellLists::build(100, 40_000, ListOrder::File, u64::MAX, &OneCellForAll).unwrap();
        for most in [1, 2, 4, 64] {
            let stretches = lists.stretches(most);
            assert!((1..=most.min(9)).contains(&stretches.len()));
            assert!(stretches.iter().cloned().flatten().eq(0..100), "{most}: {stretches:?}");
            // no more than a fair part and one cell
            let ids = |r: &Range<usize>| r.clone().map(|c| lists.list(c).len()).sum::<usize>();
            let longest = stretches.iter().map(ids).max().unwrap();
            assert!(longest <= 40_000 / stretches.len() + 20_400, "{most}: {longest}");
        }
        let only = |lists: CellLists| (lists.stretches(8).len(), lists.stretches(8)[0].clone());
        assert_eq!(only(build(ListOrder::File, 99).unwrap()), (1, 0..5));
        assert_eq!(only(CellLists::default()), (1, 0..0));
    }

    #[test]
    fn lists_are_built_again_where_others_were() {
        let mut lists = build(ListOrder::File, 99).unwrap();
        for (cells, primitives) in [(5, 2), (7, 9), (5, 0)] {
            for order in [ListOrder::Reverse, ListOrder::File] {
                lists.rebuild(cells, primitives, order, &TwoCellsEach);
                let new = CellLists::build(cells, primitives, order, 99, &TwoCellsEach).unwrap();
                assert_eq!(lists, new);
            }
        }
    }

    #[test]
    fn too_many_references_are_refused() {
        assert_eq!(build(ListOrder::File, 11), Err(TooManyReferences(12)));
    }
}
