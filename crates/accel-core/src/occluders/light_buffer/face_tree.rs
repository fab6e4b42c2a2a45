//! The cells of a face: a coarse grid over the part of the face that shows anything, and in its
//! cells trees that go deeper where lists are long.
//!
//! A cell is one word: the place of its list, or of its 4 x 4 subcells. A list is sorted by depth
//! and ends with a record that no ray is deep enough for. A record says in which part of the cell
//! its primitive is seen, so that few of a list are tested.

use glam::{DVec2, dvec2};

use crate::geometry::ray::MISS;
use crate::geometry::scalar::Scalar;
use crate::memory::prefetch;
use crate::occluders::light_buffer::cell_part::{CellPoint, CellRegion, SPOT_BITS};
use crate::occluders::light_buffer::margins::Margins;
use crate::query::counters::add_fields;

/// An entry of a list.
#[derive(Debug, Clone, Copy)]
pub(super) struct Record<S> {
    /// Rays less deep than this cannot meet it.
    pub(super) near: S,
    /// The primitive, or one of [`END`], [`COVERED`], [`LONG`].
    pub(super) id: u32,
    /// Rays through other parts of the cell cannot meet it.
    pub(super) part: CellRegion,
}

impl<S: Scalar> Record<S> {
    /// End marker of a list.
    pub(super) fn end() -> Self {
        Self { near: S::INFINITY, id: END, part: CellRegion::ALL }
    }
}

pub(super) const END: u32 = MISS;
/// First of a list: whatever is deeper is hidden by one primitive that covers the cell.
pub(super) const COVERED: u32 = MISS - 1;
/// The only record of a list that is left to a structure.
pub(super) const LONG: u32 = MISS - 2;

/// Marks a cell that is divided.
pub(super) const DIVIDED: u32 = 1 << 31;
/// The most cells or records whose index fits into a cell's word.
pub(super) const INDEX_LIMIT: u128 = DIVIDED as u128;
/// The most primitives; higher numbers mean something else in lists.
pub(super) const ID_LIMIT: u128 = LONG as u128;
/// Two bits of u and of v a level.
pub(super) const LEVEL_BITS: u32 = 2;

/// A face: the part of it that shows anything, and its coarse grid.
#[derive(Debug, Clone, Copy)]
pub(super) struct Face<S> {
    low: [S; 2],
    scale: [S; 2],
    /// Spots of finest cells per side; 0 for a face that shows nothing.
    side: S,
    /// The first cell of the coarse grid.
    first: u32,
    /// Bits of a coordinate, in spots of finest cells, below the coarse grid.
    shift: u32,
    /// Bits of the coarse grid.
    bits: u32,
}

/// Result of looking up a direction on a face.
#[derive(Debug, Clone, Copy)]
pub(super) struct FaceLookup {
    /// The first record of the list.
    pub(super) first: u32,
    /// Levels passed on the way.
    pub(super) levels: u32,
    /// Point at which the direction passes through the cell.
    pub(super) spot: CellPoint,
}

impl<S: Scalar> Face<S> {
    /// A face that shows nothing.
    pub(super) fn empty() -> Self {
        let zero = [S::ZERO; 2];
        Self { low: zero, scale: zero, side: S::ZERO, first: 0, shift: 0, bits: 0 }
    }

    /// A face over a rectangle, with 2 to the power of the first of `bits` finest cells per side,
    /// and of the second a coarse grid that begins at the cell `first`. Also where it begins and
    /// the extent of a finest cell, in f64.
    pub(super) fn over(
        low: DVec2,
        high: DVec2,
        margins: &Margins,
        [finest, coarse]: [u32; 2],
        first: u32,
    ) -> (Self, DVec2, DVec2) {
        let (cells, spots) = (f64::from(1u32 << finest), f64::from(1u32 << SPOT_BITS));
        let side = cells * spots;
        // footprints end well inside, so that no rounding puts a direction they show outside
        let margin = DVec2::splat(margins.direction * 4.0);
        let low = (low - margin).to_array().map(|x| S::from_f64(x).next_down());
        let start = dvec2(low[0].to_f64(), low[1].to_f64());
        let size = high + margin * 2.0 - start;
        let scale = size.to_array().map(|x| S::from_f64(side / x).next_down());
        let step = dvec2(spots / scale[0].to_f64(), spots / scale[1].to_f64());
        let (side, shift) = (S::from_f64(side), finest - coarse + SPOT_BITS);
        (Self { low, scale, side, first, shift, bits: coarse }, start, step)
    }

    /// The cell of the coarse grid that a spot is in.
    #[inline(always)]
    fn coarse(&self, (x, y): (u32, u32)) -> usize {
        (self.first + ((y >> self.shift) << self.bits) + (x >> self.shift)) as usize
    }

    /// The spot of a finest cell that a direction is in; `None` outside.
    #[inline(always)]
    fn spot(&self, at: [S; 2]) -> Option<(u32, u32)> {
        let x = (at[0] - self.low[0]) * self.scale[0];
        let y = (at[1] - self.low[1]) * self.scale[1];
        // also refuses NaN
        let is_inside = (x >= S::ZERO) & (x < self.side) & (y >= S::ZERO) & (y < self.side);
        is_inside.then(|| (x.to_i32() as u32, y.to_i32() as u32))
    }

    /// Begins to load the cell of the coarse grid that a direction is in.
    #[inline(always)]
    pub(super) fn prefetch(&self, cells: &[u32], at: [S; 2]) {
        if let Some(cell) = self.spot(at).and_then(|spot| cells.get(self.coarse(spot))) {
            prefetch(cell);
        }
    }

    /// The list for a direction; `None` outside the part that shows anything.
    #[inline(always)]
    pub(super) fn find(&self, cells: &[u32], at: [S; 2]) -> Option<FaceLookup> {
        let (x, y) = self.spot(at)?;
        let mut shift = self.shift;
        let mut cell = cells[self.coarse((x, y))];
        let mut levels = 1;
        while cell & DIVIDED != 0 {
            shift -= LEVEL_BITS;
            let sub = ((y >> shift & 3) << LEVEL_BITS) + (x >> shift & 3);
            cell = cells[((cell & !DIVIDED) + sub) as usize];
            levels += 1;
        }
        let shift = shift - SPOT_BITS;
        Some(FaceLookup { first: cell, levels, spot: CellPoint::of(x >> shift, y >> shift) })
    }
}

/// Counts of a build.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct BuildCounts {
    /// Cells that are divided, and coarse grids.
    pub(super) inner: u64,
    pub(super) leaves: u64,
    /// Number of empty ones.
    pub(super) empty: u64,
    pub(super) references: u64,
    /// Lists left to a structure.
    pub(super) long: u64,
    /// Cells covered by one primitive.
    pub(super) covered: u64,
}

add_fields!(BuildCounts: inner, leaves, empty, references, long, covered);

/// All cells and lists of a buffer.
#[derive(Debug)]
pub(super) struct Cells<S> {
    pub(super) cells: Vec<u32>,
    /// The lists; the first one is empty.
    pub(super) records: Vec<Record<S>>,
    pub(super) tally: BuildCounts,
}

impl<S: Scalar> Cells<S> {
    pub(super) fn new() -> Self {
        Self { cells: Vec::new(), records: vec![Record::end()], tally: BuildCounts::default() }
    }

    pub(super) fn bytes(&self) -> usize {
        size_of_val(self.cells.as_slice()) + size_of_val(self.records.as_slice())
    }

    /// Current sizes, for [`Cells::cut`].
    pub(super) fn extent(&self) -> (usize, usize, BuildCounts) {
        (self.cells.len(), self.records.len(), self.tally)
    }

    /// Goes back to what there was.
    pub(super) fn cut(&mut self, (cells, records, tally): (usize, usize, BuildCounts)) {
        self.cells.truncate(cells);
        self.records.truncate(records);
        self.tally = tally;
    }

    /// Takes over the cells and lists of another, whose first record is moved to here as well;
    /// returns what its words for cells become at their new places.
    pub(super) fn append(&mut self, mut other: Self) -> impl Fn(u32) -> u32 + use<S> {
        let (cells, records) = (self.cells.len() as u32, self.records.len() as u32);
        let moved = move |word: u32| match word {
            // the empty list stays where it is
            0 => 0,
            _ if word & DIVIDED != 0 => word.wrapping_add(cells) | DIVIDED,
            _ => word.wrapping_add(records),
        };
        self.cells.extend(other.cells.iter().map(|&word| moved(word)));
        self.records.append(&mut other.records);
        self.tally += other.tally;
        moved
    }
}
