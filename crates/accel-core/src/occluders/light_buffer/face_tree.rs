//! The cells of a face: a coarse grid over the part of the face that shows anything, and in its
//! cells trees that go deeper where lists are long.
//!
//! A cell is one word: the place of its list, or of its 4 x 4 subcells. A list is sorted by depth
//! and ends with a record that no ray is deep enough for.

use glam::{DVec2, dvec2};

use super::facing::Facing;
use super::footprint::{Footprint, HalfPlane};
use super::margins::Margins;
use crate::ray::MISS;
use crate::scalar::Scalar;

/// An entry of a list.
#[derive(Debug, Clone, Copy)]
pub(super) struct Record<S> {
    /// Rays less deep than this cannot meet it.
    pub(super) near: S,
    /// The primitive, or one of [`END`], [`COVERED`], [`LONG`].
    pub(super) id: u32,
}

/// Ends a list.
pub(super) const END: u32 = MISS;
/// First of a list: whatever is deeper is hidden by one primitive that covers the cell.
pub(super) const COVERED: u32 = MISS - 1;
/// The only record of a list that is left to a structure.
pub(super) const LONG: u32 = MISS - 2;

/// Marks a cell that is divided.
pub(super) const DIVIDED: u32 = 1 << 31;
/// Two bits of u and of v a level.
const LEVEL_BITS: u32 = 2;
/// Subcells of a cell.
const FAN: usize = 16;
/// References that the cells of a coarse grid may have for each primitive, about.
const COARSE_GROWTH: f64 = 8.0;

/// A face: the part of it that shows anything, and its coarse grid.
#[derive(Debug, Clone, Copy)]
pub(super) struct Face<S> {
    low: [S; 2],
    scale: [S; 2],
    /// Finest cells a side; 0 for a face that shows nothing.
    side: S,
    /// The first cell of the coarse grid.
    first: u32,
    /// Bits of a coordinate below the coarse grid.
    shift: u32,
    /// Bits of the coarse grid.
    bits: u32,
}

impl<S: Scalar> Face<S> {
    /// A face that shows nothing.
    pub(super) fn empty() -> Self {
        let zero = [S::ZERO; 2];
        Self { low: zero, scale: zero, side: S::ZERO, first: 0, shift: 0, bits: 0 }
    }

    /// A face over a rectangle, with 2 to the power of the first of `bits` finest cells a side,
    /// and of the second a coarse grid that begins at the cell `first`. Also where it begins and
    /// the extent of a finest cell, in f64.
    pub(super) fn over(
        low: DVec2,
        high: DVec2,
        margins: &Margins,
        [finest, coarse]: [u32; 2],
        first: u32,
    ) -> (Self, DVec2, DVec2) {
        let side = f64::from(1u32 << finest);
        // footprints end well inside, so that no rounding puts a direction they show outside
        let margin = DVec2::splat(margins.direction * 4.0);
        let low = (low - margin).to_array().map(|x| S::from_f64(x).next_down());
        let start = dvec2(low[0].to_f64(), low[1].to_f64());
        let size = high + margin * 2.0 - start;
        let scale = size.to_array().map(|x| S::from_f64(side / x).next_down());
        let step = dvec2(1.0 / scale[0].to_f64(), 1.0 / scale[1].to_f64());
        let (side, shift) = (S::from_f64(side), finest - coarse);
        (Self { low, scale, side, first, shift, bits: coarse }, start, step)
    }

    /// The cell of the coarse grid that a direction is in; `None` outside.
    pub(super) fn index(&self, at: [S; 2]) -> Option<usize> {
        let (x, y) = self.finest(at)?;
        Some((self.first + ((y >> self.shift) << self.bits) + (x >> self.shift)) as usize)
    }

    /// The finest cell that a direction is in; `None` outside.
    #[inline(always)]
    fn finest(&self, at: [S; 2]) -> Option<(u32, u32)> {
        let x = (at[0] - self.low[0]) * self.scale[0];
        let y = (at[1] - self.low[1]) * self.scale[1];
        // also refuses NaN
        let is_inside = (x >= S::ZERO) & (x < self.side) & (y >= S::ZERO) & (y < self.side);
        is_inside.then(|| (x.to_i32() as u32, y.to_i32() as u32))
    }

    /// The list for a direction and the levels passed on the way; `None` outside the part that
    /// shows anything.
    #[inline(always)]
    pub(super) fn find(&self, cells: &[u32], at: [S; 2]) -> Option<(u32, u32)> {
        let (x, y) = self.finest(at)?;
        let mut shift = self.shift;
        let mut cell = cells[(self.first + ((y >> shift) << self.bits) + (x >> shift)) as usize];
        let mut levels = 1;
        while cell & DIVIDED != 0 {
            shift -= LEVEL_BITS;
            let sub = ((y >> shift & 3) << LEVEL_BITS) + (x >> shift & 3);
            cell = cells[((cell & !DIVIDED) + sub) as usize];
            levels += 1;
        }
        Some((cell, levels))
    }
}

/// What bounds the work of a build.
#[derive(Debug, Clone, Copy)]
pub(super) struct Limits {
    /// Finest cells a side of a face: 2 to this power.
    pub(super) bits: u32,
    /// Lists longer than this are divided.
    pub(super) divide: usize,
    /// Cells are not divided where that makes more references than this of one of the coarse
    /// grid: a stack of large primitives would otherwise be divided along its edge without end.
    pub(super) growth: f64,
    /// Lists that remain longer than this are left to a structure.
    pub(super) longest: usize,
    /// Whether primitives that cover a cell cut its list off.
    pub(super) cut_off: bool,
}

/// Counts of a build.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Tally {
    /// Cells that are divided, and coarse grids.
    pub(super) inner: u64,
    /// Cells with lists.
    pub(super) leaves: u64,
    /// Of those, empty ones.
    pub(super) empty: u64,
    /// Records of primitives.
    pub(super) references: u64,
    /// Lists left to a structure.
    pub(super) long: u64,
    /// Cells covered by one primitive.
    pub(super) covered: u64,
}

/// All cells and lists of a buffer.
#[derive(Debug)]
pub(super) struct Cells<S> {
    /// See [`Face::find`].
    pub(super) cells: Vec<u32>,
    /// The lists; the first one is empty.
    pub(super) records: Vec<Record<S>>,
    /// What there is.
    pub(super) tally: Tally,
}

impl<S: Scalar> Cells<S> {
    /// Nothing yet.
    pub(super) fn new() -> Self {
        let end = Record { near: S::INFINITY, id: END };
        Self { cells: Vec::new(), records: vec![end], tally: Tally::default() }
    }
}

/// The footprints on one face.
#[derive(Debug, Default)]
pub(super) struct Shown {
    /// One for each primitive.
    pub(super) footprints: Vec<Footprint>,
    /// Their half-planes.
    pub(super) sides: Vec<HalfPlane>,
    /// Their planes.
    pub(super) planes: Vec<Facing>,
}

impl Shown {
    pub(super) fn clear(&mut self) {
        self.footprints.clear();
        self.sides.clear();
        self.planes.clear();
    }

    fn plane(&self, footprint: &Footprint) -> Option<&Facing> {
        self.planes.get(footprint.plane? as usize)
    }
}

/// Fills one face.
pub(super) struct Filling<'a, S> {
    pub(super) shown: &'a Shown,
    pub(super) limits: Limits,
    pub(super) margins: &'a Margins,
    pub(super) out: &'a mut Cells<S>,
    low: DVec2,
    /// Extent of a finest cell.
    step: DVec2,
}

impl<'a, S: Scalar> Filling<'a, S> {
    /// Makes the cells of a face.
    pub(super) fn face(
        shown: &'a Shown,
        limits: Limits,
        margins: &'a Margins,
        out: &'a mut Cells<S>,
    ) -> Face<S> {
        let Some(first) = shown.footprints.first() else { return Face::empty() };
        let all = shown.footprints.iter();
        let bounds = (first.low, first.high);
        let (low, high) = all.fold(bounds, |(l, h), f| (l.min(f.low), h.max(f.high)));
        let mut bits = coarse_bits(shown, high - low).min(limits.bits);
        // whole levels below
        bits += (limits.bits - bits) % LEVEL_BITS;
        let first = out.cells.len() as u32;
        let (face, low, step) = Face::over(low, high, margins, [limits.bits, bits], first);
        out.cells.resize(out.cells.len() + (1 << (2 * bits)), 0);
        out.tally.inner += 1;
        Filling { shown, limits, margins, out, low, step }.coarse(&face);
        face
    }

    fn coarse(&mut self, face: &Face<S>) {
        let side = 1u32 << face.bits;
        let cell = self.step * f64::from(1u32 << face.shift);
        let half = cell * 0.5;
        let mut pairs: Vec<(u32, u32)> = Vec::new();
        for (i, f) in self.shown.footprints.iter().enumerate() {
            // one cell more on every side: the test below decides
            let from = ((f.low - self.low) / cell - 1.0).max(DVec2::ZERO);
            let to = ((f.high - self.low) / cell + 1.0).min(DVec2::splat(f64::from(side - 1)));
            for y in from.y as u32..=to.y as u32 {
                for x in from.x as u32..=to.x as u32 {
                    let center = self.low + dvec2(f64::from(x), f64::from(y)) * cell + half;
                    if f.overlaps(&self.shown.sides, center, half) {
                        pairs.push(((y << face.bits) + x, i as u32));
                    }
                }
            }
        }
        pairs.sort_unstable();
        let mut rest = pairs.as_slice();
        let mut list = Vec::new();
        for c in 0..side * side {
            let n = rest.iter().take_while(|p| p.0 == c).count();
            let (own, others) = rest.split_at(n);
            rest = others;
            list.clear();
            list.extend(own.iter().map(|p| p.1));
            let at = [(c & (side - 1)) << face.shift, (c >> face.bits) << face.shift];
            let word = self.cell(&mut list, at, face.shift, [1.0, 1.0]);
            self.out.cells[(face.first + c) as usize] = word;
        }
    }

    /// Centre and half extent of the cell of that size at `at`, in finest cells.
    fn rectangle(&self, at: [u32; 2], shift: u32) -> (DVec2, DVec2) {
        let half = self.step * (f64::from(1u32 << shift) * 0.5);
        (self.low + dvec2(f64::from(at[0]), f64::from(at[1])) * self.step + half, half)
    }

    /// A lower bound on the depth of a footprint within a cell.
    fn near(&self, footprint: &Footprint, center: DVec2, half: DVec2) -> f64 {
        let plane = self.shown.plane(footprint);
        plane.map_or(0.0, |p| p.near(center, half)).max(footprint.near)
    }

    /// The depth beyond which one primitive hides everything in the cell.
    fn cover(&self, list: &[u32], center: DVec2, half: DVec2) -> Option<f64> {
        if !self.limits.cut_off {
            return None;
        }
        // directions that rounding brings into the cell are covered too
        let half = half + self.margins.direction * 2.0;
        let far = |&i: &u32| self.shown.plane(self.footprint(i))?.covers(center, half);
        list.iter().filter_map(far).min_by(f64::total_cmp)
    }

    fn footprint(&self, i: u32) -> &'a Footprint {
        &self.shown.footprints[i as usize]
    }

    /// Makes a cell of the footprints in `list`, dividing it where that pays. The first of
    /// `growth` says how many references each of those of the coarse cell has become, the second
    /// by how much the last division made them more: the next makes them more by at least about
    /// as much, so that one which would be given up need not be tried.
    fn cell(&mut self, list: &mut Vec<u32>, at: [u32; 2], shift: u32, growth: [f64; 2]) -> u32 {
        let (center, half) = self.rectangle(at, shift);
        let cover = self.cover(list, center, half).map(|far| far * (1.0 + self.margins.depth));
        if let Some(far) = cover {
            list.retain(|&i| self.near(self.footprint(i), center, half) <= far);
        }
        let is_given_up = growth[0] * growth[1] > self.limits.growth;
        if list.len() <= self.limits.divide || shift < LEVEL_BITS || is_given_up {
            return self.leaf(list, cover, center, half);
        }
        let below = shift - LEVEL_BITS;
        let sub = |k: u32| [at[0] + ((k & 3) << below), at[1] + ((k >> LEVEL_BITS) << below)];
        let mut parts: [Vec<u32>; FAN] = Default::default();
        let mut total = 0;
        for (k, part) in parts.iter_mut().enumerate() {
            let (center, half) = self.rectangle(sub(k as u32), below);
            let shows = |&&i: &&u32| self.footprint(i).overlaps(&self.shown.sides, center, half);
            part.extend(list.iter().filter(shows));
            total += part.len();
        }
        let more = (total as f64 / list.len() as f64).max(1.0);
        let growth = [growth[0] * more, more];
        // not worth it where nearly every primitive is seen in nearly every part
        let is_alike = total * 4 > list.len() * FAN * 3 && !self.pays(&parts, sub, below);
        if is_alike || growth[0] > self.limits.growth {
            return self.leaf(list, cover, center, half);
        }
        let first = self.out.cells.len();
        self.out.cells.resize(first + FAN, 0);
        self.out.tally.inner += 1;
        for (k, part) in parts.iter_mut().enumerate() {
            let word = self.cell(part, sub(k as u32), below, growth);
            self.out.cells[first + k] = word;
        }
        first as u32 | DIVIDED
    }

    /// Whether parts of a cell are covered, so that their lists may end early.
    fn pays(&self, parts: &[Vec<u32>; FAN], sub: impl Fn(u32) -> [u32; 2], below: u32) -> bool {
        let is_covered = |(k, part): (usize, &Vec<u32>)| {
            let (center, half) = self.rectangle(sub(k as u32), below);
            self.cover(part, center, half).is_some()
        };
        parts.iter().enumerate().filter(|&p| is_covered(p)).count() * 2 > FAN
    }

    /// Writes a list.
    fn leaf(&mut self, list: &[u32], cover: Option<f64>, center: DVec2, half: DVec2) -> u32 {
        let tally = &mut self.out.tally;
        tally.leaves += 1;
        if list.is_empty() {
            tally.empty += 1;
            return 0;
        }
        let mut entries: Vec<(f64, u32)> = list
            .iter()
            .map(|&i| (self.near(self.footprint(i), center, half), self.footprint(i).id))
            .collect();
        entries.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let first = self.out.records.len() as u32;
        let below = |x: f64| S::from_f64(x * (1.0 - self.margins.depth)).next_down();
        let records = &mut self.out.records;
        let tally = &mut self.out.tally;
        if let Some(far) = cover {
            records.push(Record { near: S::from_f64(far).next_up(), id: COVERED });
            tally.covered += 1;
        }
        if entries.len() > self.limits.longest {
            tally.long += 1;
            let near = entries.first().map_or(0.0, |e| e.0);
            records.push(Record { near: below(near), id: LONG });
        } else {
            tally.references += entries.len() as u64;
            records.extend(entries.iter().map(|&(near, id)| Record { near: below(near), id }));
        }
        records.push(Record { near: S::INFINITY, id: END });
        first
    }
}

/// The resolution of a coarse grid, 2 to this power: about as many cells as footprints, fewer
/// where these are large.
fn coarse_bits(shown: &Shown, size: DVec2) -> u32 {
    let (mut area, mut edges) = (0.0, 0.0);
    for f in &shown.footprints {
        let part = (f.high - f.low) / size;
        area += part.x * part.y;
        edges += part.x + part.y;
    }
    let n = shown.footprints.len() as f64;
    let references = |r: f64| area * r * r + edges * r + n;
    let fits = |&bits: &u32| {
        let side = f64::from(1u32 << bits);
        side * side <= n * 2.0 && references(side) <= n * COARSE_GROWTH
    };
    (0..=8).rev().find(fits).unwrap_or(0)
}
