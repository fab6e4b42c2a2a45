//! Lists of a dense grid in which every primitive goes to a block of cells: a counting sort, on
//! all threads of the current rayon pool.
//!
//! Paper: T. Ize, I. Wald, C. Robertson, S. Parker, "An Evaluation of Parallel Grid Construction
//! for Ray Tracing Dynamic Scenes", IEEE Symposium on Interactive Ray Tracing, 2006 (their
//! sort-last build: each thread has a grid for its part of the primitives, merged in the end).
//!
//! Deviations: a thread has only counters, not lists; they are turned into the places in the one
//! array at which it then fills its primitives in, so nothing is merged or moved. The block of a
//! primitive is found once, when counting, and kept in 8 bytes for filling. Parts stand in their
//! order within each list, so lists are the same for any number of threads.

use std::ops::Range;
use std::sync::atomic::{AtomicU32, Ordering};

use rayon::prelude::*;

use crate::cell_lists::{CellLists, ListOrder, TooManyReferences};
use crate::parallel::parts;

/// Says to which block of cells a primitive goes.
pub(crate) trait BlockPlacement: Sync {
    /// First and last cell on each axis, within the grid; the same ones each time it is asked.
    fn block(&self, id: u32) -> ([i32; 3], [i32; 3]);
}

/// Builds the lists of a grid of `n` cells an axis, x fastest, for primitives `0..primitives`.
///
/// # Errors
/// [`TooManyReferences`] when the references exceed `max_references`; cells are not visited
/// any further then.
pub(crate) fn block_lists(
    n: [u32; 3],
    primitives: usize,
    order: ListOrder,
    max_references: u64,
    placement: &impl BlockPlacement,
) -> Result<CellLists, TooManyReferences> {
    let grid = Grid::new(n);
    let max_references = max_references.min(u64::from(u32::MAX));
    let size = primitives.div_ceil(useful_parts(primitives, grid.cells)).max(1);
    let mut kept = vec![0; primitives];
    let count = |(i, kept): (usize, &mut [u64])| {
        grid.count((i * size) as u32, kept, max_references, placement)
    };
    let counted: Vec<(Vec<u32>, u64)> = if size >= primitives {
        vec![count((0, &mut kept))]
    } else {
        kept.par_chunks_mut(size).enumerate().map(count).collect()
    };
    let total = counted.iter().fold(0u64, |sum, (_, n)| sum.saturating_add(*n));
    if total > max_references {
        return Err(TooManyReferences(total));
    }
    let mut cursors: Vec<Vec<u32>> = counted.into_iter().map(|(counts, _)| counts).collect();
    let parts: Vec<Range<usize>> =
        (0..cursors.len()).map(|i| i * size..((i + 1) * size).min(primitives)).collect();
    let mut ids = vec![0; total as usize];
    let shared = shared(&mut ids);
    let fill = |(cursor, part): (&mut Vec<u32>, Range<usize>)| {
        grid.fill(part.start as u32, &kept[part], order, cursor, shared, placement);
    };
    // the part whose ids come first in a list comes first: its cursors end as the lists' starts
    if order == ListOrder::Reverse {
        cursors.reverse();
    }
    turn_into_ends(&mut cursors);
    if let [cursor] = cursors.as_mut_slice() {
        parts.into_iter().for_each(|part| fill((&mut *cursor, part)));
    } else {
        let in_list_order: Vec<_> = match order {
            ListOrder::File => parts,
            ListOrder::Reverse => parts.into_iter().rev().collect(),
        };
        cursors.par_iter_mut().zip(in_list_order).for_each(fill);
    }
    let starts = cursors.into_iter().next().unwrap_or_default();
    Ok(CellLists::of_parts(starts, ids))
}

/// Counters of all parts together may take as much memory as this for each primitive.
const COUNTER_BYTES: usize = 256;

/// How many parts: no more than there is memory for, as each has counters of its own.
fn useful_parts(primitives: usize, cells: usize) -> usize {
    let affordable = primitives.saturating_mul(COUNTER_BYTES / 4) / cells.max(1);
    parts(primitives).min(affordable.max(1))
}

/// Cell counts of a grid and the way from a cell to its neighbours.
#[derive(Clone, Copy)]
struct Grid {
    cells: usize,
    row: usize,
    layer: usize,
}

/// The block of a primitive in 8 bytes: its first cell, and how many more follow on each axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Block {
    first: usize,
    more: [usize; 3],
}

/// Marks a block that is too long for 8 bytes: it is asked for again.
const TOO_LONG: u64 = u64::MAX;

impl Block {
    /// In 8 bytes, if it fits.
    #[inline(always)]
    fn packed(self) -> u64 {
        let [x, y, z] = self.more;
        if x.max(y).max(z) > 0xFF {
            return TOO_LONG;
        }
        self.first as u64 | (x as u64) << 32 | (y as u64) << 40 | (z as u64) << 48
    }

    /// What was packed.
    #[inline(always)]
    fn of_packed(packed: u64) -> Self {
        let byte = |shift: u32| (packed >> shift & 0xFF) as usize;
        Self { first: packed as u32 as usize, more: [byte(32), byte(40), byte(48)] }
    }

    /// How many cells.
    #[inline(always)]
    fn cells(self) -> u64 {
        self.more.iter().map(|&m| m as u64 + 1).product()
    }
}

impl Grid {
    fn new(n: [u32; 3]) -> Self {
        let [x, y, z] = n.map(|n| n as usize);
        Self { cells: x * y * z, row: x, layer: x * y }
    }

    #[inline(always)]
    fn block(&self, id: u32, placement: &impl BlockPlacement) -> Block {
        let (first, last) = placement.block(id);
        let [x, y, z] = first.map(|i| i as usize);
        Block {
            first: z * self.layer + y * self.row + x,
            more: std::array::from_fn(|k| (last[k] - first[k]) as usize),
        }
    }

    /// Calls `visit` with the cells of a block, row by row.
    #[inline(always)]
    fn rows(&self, block: Block, mut visit: impl FnMut(Range<usize>)) {
        let [x, y, z] = block.more;
        // most primitives are in one cell, or in one row
        if y + z == 0 {
            return visit(block.first..block.first + x + 1);
        }
        for k in 0..=z {
            for j in 0..=y {
                let start = block.first + k * self.layer + j * self.row;
                visit(start..start + x + 1);
            }
        }
    }

    /// How many primitives of a part, which begins with id `first`, go to each cell (and a zero),
    /// and to all of them; keeps their blocks. Beyond `max_references` only the sum is right.
    fn count(
        &self,
        first: u32,
        kept: &mut [u64],
        max_references: u64,
        placement: &impl BlockPlacement,
    ) -> (Vec<u32>, u64) {
        let mut counts = vec![0u32; self.cells + 1];
        let mut total = 0u64;
        for (id, kept) in (first..).zip(kept) {
            let block = self.block(id, placement);
            *kept = block.packed();
            total = total.saturating_add(block.cells());
            if block.more == [0; 3] {
                counts[block.first] += 1;
            } else if total <= max_references {
                self.rows(block, |row| counts[row].iter_mut().for_each(|n| *n += 1));
            }
        }
        (counts, total)
    }

    /// Writes the ids of a part, which begins with id `first`, to their places: each cursor goes
    /// down from the end of the part's ids in that list to their start.
    fn fill(
        &self,
        first: u32,
        kept: &[u64],
        order: ListOrder,
        cursors: &mut [u32],
        ids: &[AtomicU32],
        placement: &impl BlockPlacement,
    ) {
        let mut place = |(id, &packed): (u32, &u64)| {
            let block = match packed {
                TOO_LONG => self.block(id, placement),
                _ => Block::of_packed(packed),
            };
            let mut put = |cursor: &mut u32| {
                *cursor -= 1;
                ids[*cursor as usize].store(id, Ordering::Relaxed);
            };
            if block.more == [0; 3] {
                put(&mut cursors[block.first]);
            } else {
                self.rows(block, |row| cursors[row].iter_mut().for_each(&mut put));
            }
        };
        // from the back: the last id placed comes first
        let in_part = (first..first + kept.len() as u32).zip(kept);
        match order {
            ListOrder::File => in_part.rev().for_each(&mut place),
            ListOrder::Reverse => in_part.for_each(&mut place),
        }
    }
}

/// Turns the counts of each part into where its ids end in the one array: cell after cell, in each
/// cell part after part.
fn turn_into_ends(counts: &mut [Vec<u32>]) {
    if let [only] = counts {
        let mut sum = 0;
        for n in only {
            sum += *n;
            *n = sum;
        }
        return;
    }
    // as many stretches of cells as parts, each with the counts of all parts
    let cells = counts.first().map_or(0, Vec::len);
    let length = cells.div_ceil(counts.len().max(1)).max(1);
    let mut stretches: Vec<Vec<&mut [u32]>> = (0..cells.div_ceil(length)).map(|_| vec![]).collect();
    for part in counts {
        for (stretch, counts) in stretches.iter_mut().zip(part.chunks_mut(length)) {
            stretch.push(counts);
        }
    }
    let sums: Vec<u32> = stretches
        .par_iter()
        .map(|parts| parts.iter().map(|counts| counts.iter().sum::<u32>()).sum())
        .collect();
    let before = sums.iter().scan(0, |sum, n| {
        let before = *sum;
        *sum += n;
        Some(before)
    });
    let before: Vec<u32> = before.collect();
    stretches.into_par_iter().zip(before).for_each(|(mut parts, mut sum)| {
        let length = parts.first().map_or(0, |counts| counts.len());
        for cell in 0..length {
            for counts in &mut parts {
                sum += counts[cell];
                counts[cell] = sum;
            }
        }
    });
}

/// The same numbers, to be written by several threads, each in places of its own.
fn shared(numbers: &mut [u32]) -> &[AtomicU32] {
    let shared = std::ptr::from_mut(numbers) as *const [AtomicU32];
    // SAFETY: an AtomicU32 has the size, alignment and bit validity of a u32, and for the lifetime
    // of the result nothing else refers to the numbers.
    unsafe { &*shared }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cell_lists::Placement;

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
            let (first, last) = self.block(id);
            for z in first[2]..=last[2] {
                for y in first[1]..=last[1] {
                    for x in first[0]..=last[0] {
                        emit((z as usize * 7 + y as usize) * 300 + x as usize);
                    }
                }
            }
        }
    }

    fn on(threads: usize, order: ListOrder, most: u64) -> Result<CellLists, TooManyReferences> {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| block_lists(N, 30_000, order, most, &Blocks))
    }

    #[test]
    fn the_lists_of_the_plain_build_for_any_number_of_threads() {
        let cells = Grid::new(N).cells;
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

    #[test]
    fn blocks_fit_into_8_bytes_or_say_so() {
        for more in [[0; 3], [255, 0, 3], [1, 255, 255]] {
            let block = Block { first: u32::MAX as usize, more };
            assert_eq!(Block::of_packed(block.packed()), block);
        }
        assert_eq!(Block { first: 0, more: [0, 256, 0] }.packed(), TOO_LONG);
    }

    #[test]
    fn as_many_parts_as_memory_allows() {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(8).build().unwrap();
        let parts = |cells| pool.install(|| useful_parts(100_000, cells));
        assert_eq!([parts(200_000), parts(2_000_000), parts(50_000_000)], [8, 3, 1]);
    }
}
