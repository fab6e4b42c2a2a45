//! Records that traversals read: 16 bytes per part of the grid, found by lattice coordinates.

use wide::{i32x4, i32x8, u8x16, u32x4, u32x8};

use crate::parallel;
use crate::structures::irregular_grid::cells::{Cells, DIVIDED, FIRST_PART};
use crate::structures::irregular_grid::lattice::{Division, Lattice};

/// Lattice coordinates, and 0.
pub(super) type Point = i32x4;

/// A part of the grid.
///
/// Undivided: the grown box, its first lattice coordinates and those after its last, 16 bits each;
/// then 32 bits with the number of a list. Divided: how far to shift a point's coordinates to the
/// right, and then the y and z ones to the left, and a number that their sum is added to: that
/// of the part's record, modulo 2^31.
#[repr(transparent)]
#[derive(Debug, Clone, Copy)]
pub(super) struct Voxel(u32x4);

impl Voxel {
    pub(super) const NOTHING: Self = Self(u32x4::ZERO);

    pub(super) fn leaf(first: [u16; 3], end: [u16; 3], list: u32) -> Self {
        Self::new(first, end, list & !DIVIDED)
    }

    /// One divided into `1 << logs` parts of sides `1 << shift`, the first of which is record
    /// `number` and begins at lattice point `first`.
    pub(super) fn divided(first: [u32; 3], shift: [u32; 3], logs: [u32; 3], number: u32) -> Self {
        let left = [0, logs[0], logs[0] + logs[1]];
        let start: u32 = (0..3).fold(0, |sum, k| sum.wrapping_add(first[k] >> shift[k] << left[k]));
        let base = number.wrapping_sub(start) | DIVIDED;
        Self::new(shift.map(|x| x as u16), left.map(|x| x as u16), base)
    }

    fn new(a: [u16; 3], b: [u16; 3], word: u32) -> Self {
        let pair = |low: u16, high: u16| u32::from(low) | u32::from(high) << 16;
        Self(u32x4::new([pair(a[0], a[1]), pair(a[2], b[0]), pair(b[1], b[2]), word]))
    }

    #[inline(always)]
    fn word(&self) -> u32 {
        self.0.to_array()[3]
    }

    /// True when it is divided.
    #[inline(always)]
    pub(super) fn is_divided(&self) -> bool {
        self.word() & DIVIDED != 0
    }

    /// The number of its list.
    #[inline(always)]
    pub(super) fn list(&self) -> u32 {
        self.word()
    }

    /// First lattice coordinates of an undivided part's box, and those after its last.
    #[inline(always)]
    pub(super) fn bounds(&self) -> ([u32; 3], [u32; 3]) {
        let ([a, b, c, _], [d, e, f, _]) =
            (pick(self, FIRST_THREE).to_array(), pick(self, NEXT_THREE).to_array());
        ([a, b, c], [d, e, f])
    }

    /// The parts of a divided one that begins at lattice point `first` and has sides `1 << shift`,
    /// and the number of the first one's record.
    pub(super) fn division(&self, first: [u32; 3], shift: [u32; 3]) -> (Division, usize) {
        let (inner, left) = self.bounds();
        let start: u32 = (0..3).fold(0, |sum, k| sum.wrapping_add(first[k] >> inner[k] << left[k]));
        let parts = std::array::from_fn(|k| 1 << (shift[k] - inner[k]));
        let number = self.word().wrapping_add(start) & !DIVIDED;
        (Division { first, shift: inner, parts }, number as usize)
    }

    /// For [`Voxel::pick`]: the coordinates after the last, or the first on axes with -1.
    #[inline(always)]
    pub(super) fn far_coordinates(down: i32x4) -> u8x16 {
        let bytes = |first: i32| first | (first + 1) << 8 | 0x8080_0000u32 as i32;
        let up = i32x4::new([bytes(6), bytes(8), bytes(10), 0x8080_8080u32 as i32]);
        // six bytes before, in both of the lower bytes
        let back = i32x4::new([0x0606, 0x0606, 0x0606, 0]);
        bytemuck::cast(up - (down & back))
    }

    /// Coordinates of the box.
    #[inline(always)]
    pub(super) fn pick(&self, which: u8x16) -> Point {
        bytemuck::cast(bytemuck::cast::<_, u8x16>(self.0).shuffle(which))
    }
}

/// Eight records, word by word.
#[derive(Debug, Clone, Copy)]
pub(super) struct Records([u32x8; 4]);

impl Records {
    pub(super) const NOTHING: Self = Self([u32x8::ZERO; 4]);

    /// The last words: of undivided ones the numbers of their lists.
    #[inline(always)]
    pub(super) fn words(&self) -> u32x8 {
        self.0[3]
    }

    /// All ones where they are divided.
    #[inline(always)]
    fn divided(&self) -> u32x8 {
        // the highest bit says it
        const { assert!(DIVIDED == 1 << 31) };
        let words: i32x8 = bytemuck::cast(self.words());
        let divided: i32x8 = words >> 31;
        bytemuck::cast(divided)
    }

    /// The first three words of 16 bits, and the next three.
    #[inline(always)]
    fn threes(&self) -> [[u32x8; 3]; 2] {
        let [a, b, c, _] = self.0;
        let low = |pair: u32x8| pair & u32x8::splat(0xffff);
        let high = |pair: u32x8| pair.unbounded_shr_scalar(16);
        [[low(a), high(a), low(b)], [high(b), low(c), high(c)]]
    }

    /// For divided voxels: record numbers of the parts at these points.
    #[inline(always)]
    fn parts(&self, [x, y, z]: &[u32x8; 3]) -> u32x8 {
        let [right, left] = self.threes();
        let y = y.unbounded_shr(right[1]).unbounded_shl(left[1]);
        let z = z.unbounded_shr(right[2]).unbounded_shl(left[2]);
        (self.words() + x.unbounded_shr(right[0]) + y + z) & u32x8::splat(!DIVIDED)
    }

    /// For undivided voxels: the coordinates after the last of their boxes, or the first on axes
    /// with -1.
    #[inline(always)]
    pub(super) fn far_planes(&self, down: &[i32x8; 3]) -> [i32x8; 3] {
        let [first, end] = self.threes();
        let far = |axis: usize| {
            let is_down: u32x8 = bytemuck::cast(down[axis]);
            bytemuck::cast(is_down.select(first[axis], end[axis]))
        };
        [far(0), far(1), far(2)]
    }
}

#[derive(Debug)]
pub(super) struct Voxels {
    /// Those of the top grid, x fastest, then those of parts.
    pub(super) records: Vec<Voxel>,
    shift: u32x4,
    strides: u32x4,
    resolution: [u32; 3],
}

impl Voxels {
    /// The records of all entries.
    pub(super) fn new(cells: &Cells, lattice: &Lattice) -> Self {
        let mut records = vec![Voxel::NOTHING; cells.entries.len()];
        let mut waiting = vec![(0, lattice.whole())];
        while let Some((begin, division)) = waiting.pop() {
            for part in 0..division.count() {
                let entry = cells.entries[begin + part];
                if entry & DIVIDED == 0 {
                    continue;
                }
                let first = division.part(part);
                let logs = [entry >> 29 & 3, entry >> 27 & 3, entry >> 25 & 3];
                let shift = std::array::from_fn(|k| division.shift[k] - logs[k]);
                let number = entry & FIRST_PART;
                let parts = logs.map(|log| 1 << log);
                waiting.push((number as usize, Division { first, shift, parts }));
                records[begin + part] = Voxel::divided(first, shift, logs, number);
            }
        }
        let ([x, y, z], top) = (lattice.levels, lattice.top);
        let mut this = Self {
            records,
            shift: u32x4::new([x, y, z, 0]),
            strides: u32x4::new([1, top[0], top[0] * top[1], 0]),
            resolution: lattice.resolution(),
        };
        this.fill(cells);
        this
    }

    /// Writes boxes and lists of cells into the records of undivided parts.
    pub(super) fn fill(&mut self, cells: &Cells) {
        const PART: usize = 1 << 12;
        let parts = self.records.chunks_mut(PART).zip(cells.entries.chunks(PART));
        parallel::map(parts, &|(records, entries)| {
            for (record, entry) in records.iter_mut().zip(entries) {
                if entry & DIVIDED == 0 {
                    let cell = &cells.cells[*entry as usize];
                    *record = Voxel::leaf(cell.first, cell.last.map(|x| x + 1), cell.list);
                }
            }
        });
    }

    /// Lattice cells on each axis.
    pub(super) fn resolution(&self) -> [u32; 3] {
        self.resolution
    }

    /// The record of the part of the top grid at a lattice point.
    #[inline(always)]
    pub(super) fn top(&self, p: Point) -> Voxel {
        let p: u32x4 = bytemuck::cast(p);
        let [x, y, z, _] = (p.unbounded_shr(self.shift) * self.strides).to_array();
        self.records[x.wrapping_add(y).wrapping_add(z) as usize]
    }

    /// The record of the part of a divided one.
    #[inline(always)]
    pub(super) fn part(&self, voxel: &Voxel, p: Point) -> Voxel {
        let p: u32x4 = bytemuck::cast(p);
        let (right, left) = (pick(voxel, FIRST_THREE), pick(voxel, NEXT_THREE));
        let [x, y, z, _] = p.unbounded_shr(right).unbounded_shl(left).to_array();
        let number = voxel.word().wrapping_add(x).wrapping_add(y).wrapping_add(z) & !DIVIDED;
        self.records[number as usize]
    }

    /// The records of the undivided parts at sixteen lattice points, by axis and lane.
    #[inline(always)]
    pub(super) fn at_sixteen(&self, at: &[[u32x8; 3]; 2]) -> [Records; 2] {
        let shift = self.shift.to_array().map(u32x8::splat);
        let strides = self.strides.to_array().map(u32x8::splat);
        let top = |[x, y, z]: &[u32x8; 3]| {
            let (y, z) = (y.unbounded_shr(shift[1]), z.unbounded_shr(shift[2]));
            x.unbounded_shr(shift[0]) + y * strides[1] + z * strides[2]
        };
        let mut numbers = [top(&at[0]), top(&at[1])];
        loop {
            let records = self.of_numbers(&numbers);
            // all ones where divided
            let divided = [records[0].divided(), records[1].divided()];
            if (divided[0] | divided[1]).to_bitmask() == 0 {
                return records;
            }
            for half in 0..2 {
                let parts = records[half].parts(&at[half]);
                numbers[half] = divided[half].select(parts, numbers[half]);
            }
        }
    }

    #[inline(always)]
    fn of_numbers(&self, numbers: &[u32x8; 2]) -> [Records; 2] {
        let [first, second] = [numbers[0].to_array(), numbers[1].to_array()];
        let pair = |lane: usize| {
            let pair = [first[lane], second[lane]].map(|number| self.records[number as usize].0);
            bytemuck::cast(pair)
        };
        let rows = [pair(0), pair(1), pair(2), pair(3), pair(4), pair(5), pair(6), pair(7)];
        let [a, b, c, d, e, f, g, h] = u32x8::transpose(rows);
        [Records([a, b, c, d]), Records([e, f, g, h])]
    }

    /// The record of the undivided part at a lattice point.
    #[inline(always)]
    pub(super) fn at(&self, p: Point) -> Voxel {
        let mut voxel = self.top(p);
        while voxel.is_divided() {
            voxel = self.part(&voxel, p);
        }
        voxel
    }
}

const NONE: u8 = 0x80;
/// The first three words of 16 bits.
#[rustfmt::skip]
const FIRST_THREE: [u8; 16] = [0, 1, NONE, NONE, 2, 3, NONE, NONE, 4, 5, NONE, NONE, NONE, NONE, NONE, NONE];
#[rustfmt::skip]
const NEXT_THREE: [u8; 16] = [6, 7, NONE, NONE, 8, 9, NONE, NONE, 10, 11, NONE, NONE, NONE, NONE, NONE, NONE];

#[inline(always)]
fn pick(voxel: &Voxel, which: [u8; 16]) -> u32x4 {
    bytemuck::cast(bytemuck::cast::<_, u8x16>(voxel.0).shuffle(u8x16::new(which)))
}
