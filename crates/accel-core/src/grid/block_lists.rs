//! Lists of a dense grid in which every primitive goes to a block of cells: a counting sort, in
//! parts (`sort_in_parts.rs`). The block of a primitive is found once, when counting, and kept in 8
//! bytes for filling.

use std::ops::Range;
use std::sync::atomic::{AtomicU32, Ordering};

use crate::geometry::aabb::Aabb;
use crate::geometry::scalar::Scalar;
use crate::grid::cell_lists::{CellLists, ListOrder, Placement, TooManyReferences};
use crate::grid::sort_in_parts::{filled, useful_parts};
use crate::grid::voxel_traversal::GridFrame;
use crate::parallel::{map, split_mut};

/// Says to which block of cells a primitive goes.
pub(crate) trait BlockPlacement: Sync {
    /// First and last cell on each axis, within the grid; the same ones each time it is asked.
    fn block(&self, id: u32) -> ([i32; 3], [i32; 3]);
}

/// Number of cells of a block.
pub(crate) fn cells_in((first, last): ([i32; 3], [i32; 3])) -> u64 {
    (0..3).map(|k| (last[k] - first[k] + 1) as u64).product()
}

/// Calls `visit` with the first cell of each row of a block, and the row's length.
#[inline(always)]
pub(crate) fn rows_in((first, last): ([i32; 3], [i32; 3]), mut visit: impl FnMut([i32; 3], usize)) {
    for z in first[2]..=last[2] {
        for y in first[1]..=last[1] {
            visit([first[0], y, z], (last[0] - first[0] + 1) as usize);
        }
    }
}

/// Calls `visit` with each cell of a block, x fastest.
#[inline(always)]
pub(crate) fn each_cell_in((first, last): ([i32; 3], [i32; 3]), mut visit: impl FnMut([i32; 3])) {
    rows_in((first, last), |[_, y, z], _| (first[0]..=last[0]).for_each(|x| visit([x, y, z])));
}

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
        rows_in(self.block(id), |start, length| {
            let first = self.frame.index(start);
            (first..first + length).for_each(&mut emit);
        });
    }
}

/// Places of the cells of a grid in the array of lists; each row along x is contiguous.
pub(crate) trait CellRows: Sync {
    /// Length of the array.
    fn cells(&self) -> usize;
    /// Where cell 0 of a row would stand; modulo 2^64, as a row may begin with cells left out.
    fn start(&self, y: usize, z: usize) -> usize;
    /// How far rows are apart along y and z, where all are as far.
    fn strides(&self) -> Option<[usize; 2]>;
}

/// All cells, x fastest.
#[derive(Debug, Clone, Copy)]
pub(crate) struct DenseRows {
    cells: usize,
    strides: [usize; 2],
}

impl DenseRows {
    /// Layout of a grid of `n` cells per axis.
    pub(crate) fn new(n: [u32; 3]) -> Self {
        let [x, y, z] = n.map(|n| n as usize);
        Self { cells: x * y * z, strides: [x, x * y] }
    }
}

impl CellRows for DenseRows {
    #[inline(always)]
    fn cells(&self) -> usize {
        self.cells
    }

    #[inline(always)]
    fn start(&self, y: usize, z: usize) -> usize {
        y * self.strides[0] + z * self.strides[1]
    }

    #[inline(always)]
    fn strides(&self) -> Option<[usize; 2]> {
        Some(self.strides)
    }
}

/// Builds the lists of the cells that `rows` places, for primitives `0..primitives`.
///
/// # Errors
/// [`TooManyReferences`] when the references exceed `max_references`; cells are not visited
/// any further then.
pub(crate) fn block_lists(
    rows: &impl CellRows,
    primitives: usize,
    order: ListOrder,
    max_references: u64,
    placement: &impl BlockPlacement,
) -> Result<CellLists, TooManyReferences> {
    let sort = Sort { rows, placement, order };
    let max_references = max_references.min(u64::from(u32::MAX));
    let parts = useful_parts(primitives, rows.cells());
    let mut kept = vec![0; primitives];
    let lengths = parts.iter().map(ExactSizeIterator::len);
    let mut kept_of: Vec<_> = parts.iter().zip(split_mut(&mut kept, lengths)).collect();
    let counted =
        map(&mut kept_of, &|(part, kept)| sort.count(part.start as u32, kept, max_references));
    let fill = |part: Range<usize>, cursors: &mut [u32], ids: &[AtomicU32]| {
        sort.fill(part.start as u32, &kept[part], cursors, ids);
    };
    filled(counted, parts, order == ListOrder::Reverse, max_references, &fill)
        .map(|(starts, ids)| CellLists::of_parts(starts, ids))
        .map_err(TooManyReferences)
}

/// The block of a primitive in 8 bytes: where its first cell stands, and how many more follow on
/// each axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Block {
    first: usize,
    more: [usize; 3],
}

/// Stands for a block that 8 bytes do not tell: it is asked for again.
const ASK_AGAIN: u64 = u64::MAX;

impl Block {
    /// In 8 bytes, if it fits.
    #[inline(always)]
    fn packed(self) -> u64 {
        let [x, y, z] = self.more;
        if x.max(y).max(z) > 0xFF {
            return ASK_AGAIN;
        }
        self.first as u64 | (x as u64) << 32 | (y as u64) << 40 | (z as u64) << 48
    }

    #[inline(always)]
    fn of_packed(packed: u64) -> Self {
        let byte = |shift: u32| (packed >> shift & 0xFF) as usize;
        Self { first: packed as u32 as usize, more: [byte(32), byte(40), byte(48)] }
    }

    /// Returns whether it lies within one row.
    #[inline(always)]
    fn is_in_one_row(self) -> bool {
        self.more[1] + self.more[2] == 0
    }

    /// Calls `visit` with the cells, row by row, where rows are `strides` apart.
    #[inline(always)]
    fn rows(self, strides: [usize; 2], mut visit: impl FnMut(Range<usize>)) {
        let [x, y, z] = self.more;
        for k in 0..=z {
            for j in 0..=y {
                let start = self.first + k * strides[1] + j * strides[0];
                visit(start..start + x + 1);
            }
        }
    }
}

/// State shared by the passes of a build.
struct Sort<'a, R, P> {
    rows: &'a R,
    placement: &'a P,
    order: ListOrder,
}

impl<R: CellRows, P: BlockPlacement> Sort<'_, R, P> {
    /// Calls `visit` with the cells of a block, row by row.
    #[inline(always)]
    fn rows_of(&self, id: u32, mut visit: impl FnMut(Range<usize>)) {
        rows_in(self.placement.block(id), |[x, y, z], length| {
            let start = self.rows.start(y as usize, z as usize).wrapping_add(x as usize);
            visit(start..start + length);
        });
    }

    /// How many primitives of a part, which begins with id `first`, go to each cell (and a zero),
    /// and to all of them; keeps their blocks. Beyond `max_references` only the sum is right.
    fn count(&self, first: u32, kept: &mut [u64], max_references: u64) -> (Vec<u32>, u64) {
        let mut counts = vec![0u32; self.rows.cells() + 1];
        let mut total = 0u64;
        for (id, kept) in (first..).zip(kept) {
            let (first, last) = self.placement.block(id);
            let [x, y, z] = first.map(|i| i as usize);
            let block = Block {
                first: self.rows.start(y, z).wrapping_add(x),
                more: std::array::from_fn(|k| (last[k] - first[k]) as usize),
            };
            if block.more == [0; 3] {
                *kept = block.packed();
                counts[block.first] += 1;
                total += 1;
                continue;
            }
            let cells = block.more.iter().map(|&m| m as u64 + 1).product();
            total = total.saturating_add(cells);
            if total > max_references {
                continue;
            }
            let add = |row: Range<usize>| counts[row].iter_mut().for_each(|n| *n += 1);
            *kept = match self.rows.strides() {
                Some(strides) => {
                    block.rows(strides, add);
                    block.packed()
                }
                None if block.is_in_one_row() => {
                    block.rows([0; 2], add);
                    block.packed()
                }
                None => {
                    self.rows_of(id, add);
                    ASK_AGAIN
                }
            };
        }
        (counts, total)
    }

    /// Writes the ids of a part, which begins with id `first`, to their places: each cursor goes
    /// down from the end of the part's ids in that list to their start.
    fn fill(&self, first: u32, kept: &[u64], cursors: &mut [u32], ids: &[AtomicU32]) {
        let strides = self.rows.strides().unwrap_or_default();
        let mut place = |(id, &packed): (u32, &u64)| {
            let mut put = |cursor: &mut u32| {
                *cursor -= 1;
                ids[*cursor as usize].store(id, Ordering::Relaxed);
            };
            let block = Block::of_packed(packed);
            if block.more == [0; 3] {
                put(&mut cursors[block.first]);
            } else if packed == ASK_AGAIN {
                self.rows_of(id, |row| cursors[row].iter_mut().for_each(&mut put));
            } else {
                block.rows(strides, |row| cursors[row].iter_mut().for_each(&mut put));
            }
        };
        // from the back: the last id placed comes first
        let in_part = (first..first + kept.len() as u32).zip(kept);
        match self.order {
            ListOrder::File => in_part.rev().for_each(&mut place),
            ListOrder::Reverse => in_part.for_each(&mut place),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::structures::test_scenes::on_threads;

    const N: [u32; 3] = [300, 7, 5];

    /// Blocks of many shapes, some longer than 8 bytes hold.
    struct Blocks;

    impl BlockPlacement for Blocks {
        fn block(&self, id: u32) -> ([i32; 3], [i32; 3]) {
            let hash = id.wrapping_mul(0x9E37_79B9);
            let first = [hash % N[0], (hash >> 10) % N[1], (hash >> 20) % N[2]];
            let more = match id % 50 {
                0 => [299, 3, 4],
                1..30 => [0; 3],
                _ => [hash >> 28, (hash >> 26) & 1, (hash >> 24) & 1],
            };
            let last = [0, 1, 2].map(|k| (first[k] + more[k]).min(N[k] - 1) as i32);
            (first.map(|i| i as i32), last)
        }
    }

    impl Placement for Blocks {
        fn cells_of(&self, id: u32, mut emit: impl FnMut(usize)) {
            each_cell_in(self.block(id), |[x, y, z]| emit(((z * 7 + y) * 300 + x) as usize));
        }
    }

    fn on(threads: usize, order: ListOrder, most: u64) -> Result<CellLists, TooManyReferences> {
        on_threads(threads, || block_lists(&DenseRows::new(N), 30_000, order, most, &Blocks))
    }

    #[test]
    fn the_lists_of_the_plain_build_for_any_number_of_threads() {
        let cells = DenseRows::new(N).cells();
        for order in [ListOrder::File, ListOrder::Reverse] {
            let plain = CellLists::build(cells, 30_000, order, u64::MAX, &Blocks).unwrap();
            for threads in [1, 2, 5] {
                assert_eq!(on(threads, order, u64::MAX).unwrap(), plain, "{threads} {order:?}");
            }
        }
        // planted fault: parts in another order than the lists' are found out
        let file = CellLists::build(cells, 30_000, ListOrder::File, u64::MAX, &Blocks).unwrap();
        assert_ne!(on(2, ListOrder::Reverse, u64::MAX).unwrap(), file);
    }

    #[test]
    fn too_many_references_are_refused_with_their_number() {
        let total = on(1, ListOrder::File, u64::MAX).unwrap().references() as u64;
        for threads in [1, 5] {
            let refused = on(threads, ListOrder::File, total - 1);
            assert_eq!(refused, Err(TooManyReferences(total)));
            assert!(on(threads, ListOrder::File, total).is_ok());
        }
    }

    /// The same cells with gaps between rows, the last row first.
    struct SparseRows;

    impl CellRows for SparseRows {
        fn cells(&self) -> usize {
            301 * 35
        }
        fn start(&self, y: usize, z: usize) -> usize {
            (34 - y - z * 7) * 301
        }
        fn strides(&self) -> Option<[usize; 2]> {
            None
        }
    }

    #[test]
    fn rows_may_stand_anywhere() {
        let dense = on(1, ListOrder::File, u64::MAX).unwrap();
        for threads in [1, 2] {
            let build = || block_lists(&SparseRows, 30_000, ListOrder::File, u64::MAX, &Blocks);
            let lists = on_threads(threads, build).unwrap();
            for (row, x) in (0..35).flat_map(|row| (0..300).map(move |x| (row, x))) {
                let start = SparseRows.start(row % 7, row / 7);
                assert_eq!(lists.list(start + x), dense.list(row * 300 + x), "row {row} {x}");
            }
        }
    }

    #[test]
    fn blocks_fit_into_8_bytes_or_say_so() {
        for more in [[0; 3], [255, 0, 3], [1, 255, 255]] {
            let block = Block { first: u32::MAX as usize, more };
            assert_eq!(Block::of_packed(block.packed()), block);
        }
        assert_eq!(Block { first: 0, more: [0, 256, 0] }.packed(), ASK_AGAIN);
    }
}
