//! The compact grid: one bit per cell, and the starts of lists of occupied cells alone, rows of
//! cells laid over each other.
//!
//! Paper: A. Lagae, P. Dutre, "Compact, Fast and Robust Grids for Ray Tracing", Computer Graphics
//! Forum 27(4) (Eurographics Symposium on Rendering), 2008. Their first structure, one offset a
//! cell into one array of lists, is how `uniform_grid.rs` keeps its cells, so this is their second,
//! the hashed grid: the offsets stand in a hash table without collisions, made by row displacement
//! (R. Tarjan, A. Yao, "Storing a Sparse Table", CACM 22(11), 1979). Each row of cells along x is
//! pushed along the table until its occupied cells meet free places only; a cell is found by the
//! displacement of its row. One bit per cell tells beforehand whether it is occupied, so that no
//! empty one touches the table.
//!
//! Deviations: lists follow each other in the order of the table, places that nobody took count as
//! empty lists, so that a list ends where the next begins. First fit looks at no more than
//! `tries` places in the front of the table and as many at its end before a row goes behind it: the
//! time of a build is linear in the number of rows. Rows are placed in their order, not sorted.
//! The traversal is that of the uniform grid, which keeps no state for the hash.

use std::ops::Range;

use crate::config;
use crate::geometry::scalar::Scalar;
use crate::grid::block_lists::{BlockPlacement, CellRows, cells_in, rows_in};
use crate::grid::cell_lists::{CellLists, TooManyReferences};
use crate::grid::cell_traversal::{CellPosition, Traversal};
use crate::grid::regular_grid::{CellStorage, Contents, QUERY_PARAM, RegularGrid, grid_params};
use crate::parallel::map_parts;
use crate::params::ParamSpec;
use crate::params::specs;
use crate::structure::{StructureInfo, StructureStats};

config! {
    /// How rows find their places.
    pub struct RowsConfig {
        /// places in the front of the table, and at its end, that a row may try
        tries: usize = ParamSpec::integer("tries", "256", 0, 1 << 20),
    }
}

pub static INFO: StructureInfo = StructureInfo {
    paper: "Lagae, Dutre 2008 (hashed grid by row displacement)",
    deviations: "first fit looks at so many places only; lists in the order of the table",
    params: grid_params!(
        specs::max_cells("536870912", 1 << 30),
        specs::MAX_REFERENCES,
        [RowsConfig::PARAMS[0], Traversal::PARAM],
        [QUERY_PARAM]
    ),
    also_tested: &[
        "kernel=scalar",
        "query=batch",
        "query=batch density=20",
        "density=20",
        "tries=0",
        "traversal=driving-axis",
        "mailbox=hash",
    ],
    ..StructureInfo::new(
        "compact-grid",
        "equal voxels, a bit each; rows of occupied ones laid over each other in one table",
    )
};

/// A grid in a table of displaced rows.
pub type CompactGrid<S> = RegularGrid<S, CompactCells>;

/// A bit for each of a number of places; those behind the last one are 0.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
struct Bits(Vec<u64>);

impl Bits {
    fn new(places: usize) -> Self {
        Self(vec![0; places.div_ceil(64)])
    }

    #[inline(always)]
    fn get(&self, place: usize) -> bool {
        self.0.get(place / 64).is_some_and(|word| word >> (place % 64) & 1 == 1)
    }

    /// The 64 bits from a place on.
    #[inline(always)]
    fn word_at(&self, place: usize) -> u64 {
        let word = |i: usize| self.0.get(i).copied().unwrap_or(0);
        let (at, shift) = (place / 64, place % 64);
        // shifted in two steps: by 64 is no shift
        word(at) >> shift | word(at + 1) << 1 << (63 - shift)
    }

    /// Sets the bits of `mask` from a place on; there is room.
    fn set_word_at(&mut self, place: usize, mask: u64) {
        let (at, shift) = (place / 64, place % 64);
        self.0[at] |= mask << shift;
        let rest = mask >> 1 >> (63 - shift);
        if rest != 0 {
            self.0[at + 1] |= rest;
        }
    }

    #[inline(always)]
    fn set(&mut self, place: usize) {
        self.0[place / 64] |= 1 << (place % 64);
    }

    /// Sets `count` bits from a place on.
    fn set_run(&mut self, place: usize, count: usize) {
        let mut done = 0;
        while done < count {
            let left = count - done;
            let mask = if left < 64 { (1 << left) - 1 } else { u64::MAX };
            self.set_word_at(place + done, mask);
            done += 64;
        }
    }

    /// The first place from `from` on whose bit is 0.
    fn first_clear(&self, from: usize) -> usize {
        let mut place = from;
        loop {
            match (!self.word_at(place)).trailing_zeros() as usize {
                64 => place += 64,
                zeros => return place + zeros,
            }
        }
    }

    fn count(&self) -> u64 {
        self.0.iter().map(|word| u64::from(word.count_ones())).sum()
    }
}

/// Place of each row of cells in the table.
#[derive(Debug, Clone)]
struct RowDisplacements {
    rows_y: usize,
    /// Place of cell 0 of each row, modulo 2^32: cells before its first occupied one need no place.
    starts: Vec<u32>,
    /// Places in the table.
    places: usize,
}

impl RowDisplacements {
    /// Rows of `n` cells per axis, of which `occupied` says which need a place.
    fn new(n: [u32; 3], occupied: &Bits, tries: usize) -> Self {
        let [length, rows_y, rows_z] = n.map(|n| n as usize);
        let mut table = Bits::default();
        let mut starts = Vec::with_capacity(rows_y * rows_z);
        // no place before `full` is free; none from `places` on is taken
        let (mut full, mut places) = (0usize, 0usize);
        let mut row = Vec::new();
        for first_cell in (0..rows_y * rows_z).map(|r| r * length) {
            let Some(skipped) = cut_out(occupied, first_cell..first_cell + length, &mut row) else {
                starts.push(0);
                continue;
            };
            let fits = |at: usize| {
                row.iter().enumerate().all(|(i, word)| table.word_at(at + i * 64) & word == 0)
            };
            full = table.first_clear(full);
            // a row's first cell is occupied: only free places are tried
            let free_from = |from: usize| {
                std::iter::successors(Some(table.first_clear(from)), |at| {
                    Some(table.first_clear(at + 1))
                })
            };
            let near_end = places.saturating_sub(tries);
            let front = free_from(full).take(tries);
            let back = free_from(near_end.max(full)).take(tries);
            let at = front.chain(back).take_while(|&at| at < places).find(|&at| fits(at));
            let at = at.unwrap_or(places);
            table.0.resize(table.0.len().max((at + row.len() * 64).div_ceil(64) + 1), 0);
            row.iter().enumerate().for_each(|(i, word)| table.set_word_at(at + i * 64, *word));
            let last = row.len() * 64 - row.last().map_or(0, |w| w.leading_zeros() as usize);
            places = places.max(at + last);
            starts.push((at as u32).wrapping_sub(skipped as u32));
        }
        Self { rows_y, starts, places }
    }

    /// Place of a cell; any number for one that is not occupied.
    #[inline(always)]
    fn place(&self, [x, y, z]: [i32; 3]) -> usize {
        let row = z as usize * self.rows_y + y as usize;
        self.starts.get(row).map_or(0, |start| start.wrapping_add(x as u32) as usize)
    }
}

/// Writes the bits of `cells` into `row`, the first that is set at position 0; returns how many
/// were skipped for that, or `None` where none is set.
fn cut_out(bits: &Bits, cells: Range<usize>, row: &mut Vec<u64>) -> Option<usize> {
    row.clear();
    let word = |from: usize| {
        let word = bits.word_at(from);
        let left = cells.end.saturating_sub(from);
        if left < 64 { word & ((1 << left) - 1) } else { word }
    };
    let mut first = cells.start;
    while word(first) == 0 {
        first += 64;
        if first >= cells.end {
            return None;
        }
    }
    first += word(first).trailing_zeros() as usize;
    row.extend((first..cells.end).step_by(64).map(word));
    while row.last() == Some(&0) {
        row.pop();
    }
    Some(first - cells.start)
}

impl CellRows for RowDisplacements {
    fn cells(&self) -> usize {
        self.places
    }

    #[inline(always)]
    fn start(&self, y: usize, z: usize) -> usize {
        // sign-extended: what is added brings a negative start back
        self.starts[z * self.rows_y + y] as i32 as usize
    }

    fn strides(&self) -> Option<[usize; 2]> {
        None
    }
}

/// Occupied cells of a grid in a table.
pub struct CompactCells {
    occupied: Bits,
    rows: RowDisplacements,
    lists: CellLists,
}

impl CellStorage for CompactCells {
    type Config = RowsConfig;

    fn cell_bytes(cells: u128) -> u128 {
        cells.div_ceil(8)
    }
    /// An id, and the place of a cell.
    const REFERENCE_BYTES: u64 = 8;

    fn build<S: Scalar>(
        contents: &Contents<S>,
        config: &RowsConfig,
    ) -> Result<Self, TooManyReferences> {
        let occupied = occupied_cells(contents)?;
        let rows = RowDisplacements::new(contents.frame.resolution(), &occupied, config.tries);
        let lists = contents.lists_of_rows(&rows)?;
        Ok(Self { occupied, rows, lists })
    }

    #[inline(always)]
    fn list(&self, cell: &impl CellPosition) -> &[u32] {
        if !self.occupied.get(cell.index()) {
            return &[];
        }
        self.lists.list(self.rows.place(cell.coords()))
    }

    fn lists<'a>(&'a self, each: &mut dyn FnMut(&'a [u32])) {
        self.lists.lists().for_each(each);
    }

    fn stats(&self) -> StructureStats {
        let (bits, starts) = (self.occupied.0.as_slice(), self.rows.starts.as_slice());
        let rows = (size_of_val(bits) + size_of_val(starts)) as u64;
        let lists = self.lists.stats();
        StructureStats { cells: self.occupied.count(), bytes: rows + lists.bytes, ..lists }
    }
}

/// Marks the cells that hold primitives.
fn occupied_cells<S: Scalar>(contents: &Contents<S>) -> Result<Bits, TooManyReferences> {
    let frame = contents.frame;
    let limit = contents.max_references.min(u64::from(u32::MAX));
    let of_part = |ids: Range<u32>| {
        let (mut bits, mut total) = (Bits::new(frame.cells()), 0u64);
        for id in ids {
            let block = contents.block(id);
            if block.0 == block.1 {
                bits.set(frame.index(block.0));
                total += 1;
                continue;
            }
            total = total.saturating_add(cells_in(block));
            if total <= limit {
                rows_in(block, |start, length| bits.set_run(frame.index(start), length));
            }
        }
        (bits, total)
    };
    let parts = map_parts(contents.primitives, of_part);
    let total = parts.iter().fold(0u64, |sum, (_, n)| sum.saturating_add(*n));
    if total > limit {
        return Err(TooManyReferences(total));
    }
    let mut parts = parts.into_iter().map(|(bits, _)| bits);
    let mut all = parts.next().unwrap_or_default();
    for part in parts {
        all.0.iter_mut().zip(part.0).for_each(|(word, more)| *word |= more);
    }
    Ok(all)
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    /// Every `every`-th cell or so of a grid.
    fn some(n: [u32; 3], every: u32) -> Bits {
        let cells: usize = n.iter().map(|&n| n as usize).product();
        let mut bits = Bits::new(cells);
        for cell in 0..cells {
            if (cell as u32).wrapping_mul(0x9E37_79B9) >> 8 < (1 << 24) / every {
                bits.set(cell);
            }
        }
        bits
    }

    /// Occupied cells, how many places they have, and the last of these.
    fn places(n: [u32; 3], occupied: &Bits, rows: &RowDisplacements) -> [Option<usize>; 3] {
        let [x, y, z] = n.map(|n| n as i32);
        let cells = (0..x * y * z).filter(|&i| occupied.get(i as usize));
        let places = cells.map(|i| rows.place([i % x, i / x % y, i / (x * y)]));
        let distinct: BTreeSet<usize> = places.clone().collect();
        [Some(places.count()), Some(distinct.len()), distinct.last().copied()]
    }

    #[test]
    fn every_occupied_cell_has_a_place_of_its_own() {
        for n in [[1, 1, 1], [5, 7, 9], [64, 8, 8], [65, 3, 70], [200, 20, 1], [1, 500, 2]] {
            for (every, tries) in [(1, 256), (3, 256), (20, 256), (20, 0), (1000, 1)] {
                let occupied = some(n, every);
                let rows = RowDisplacements::new(n, &occupied, tries);
                let [cells, distinct, last] = places(n, &occupied, &rows);
                assert_eq!(distinct, cells, "{n:?} 1/{every}: two cells in one place");
                assert!(last.is_none_or(|last| last < rows.places), "{n:?} 1/{every}");
                assert!(rows.places <= (n[0] * n[1] * n[2]) as usize + 1);
            }
        }
        // planted fault: a row that is moved onto another is found by the same test
        let n = [64, 8, 8];
        let occupied = some(n, 3);
        let mut rows = RowDisplacements::new(n, &occupied, 256);
        rows.starts[20] = rows.starts[21];
        let [cells, distinct, _] = places(n, &occupied, &rows);
        assert!(distinct < cells);
    }

    #[test]
    fn rows_of_few_cells_fill_the_gaps_of_others() {
        let n = [100, 60, 60];
        let occupied = some(n, 10);
        let cells = occupied.count() as usize;
        let packed = RowDisplacements::new(n, &occupied, 256).places;
        let appended = RowDisplacements::new(n, &occupied, 0).places;
        assert!(packed < cells * 3 / 2, "{packed} places for {cells} cells");
        assert!(appended > cells * 5, "without trying: {appended} places for {cells} cells");
    }

    #[test]
    fn bits_across_words() {
        let mut bits = Bits::new(300);
        bits.set_run(60, 130);
        assert!((0..300).all(|i| bits.get(i) == (60..190).contains(&i)));
        assert_eq!((bits.count(), bits.first_clear(3), bits.first_clear(60)), (130, 3, 190));
        assert_eq!(bits.word_at(60), u64::MAX);
        assert_eq!(bits.word_at(189), 1);
        assert!(!bits.get(5000));
        let mut row = Vec::new();
        assert_eq!(cut_out(&bits, 40..200, &mut row), Some(20));
        assert_eq!(row, [u64::MAX, u64::MAX, 3]);
        assert_eq!(cut_out(&bits, 200..300, &mut row), None);
        assert_eq!(cut_out(&bits, 60..61, &mut row), Some(0));
        assert_eq!(row, [1]);
    }
}
