//! Divides a set of boxes between two of equal bins of their centres, where the surface-area
//! heuristic is least.

use wide::{f32x4, i32x4};

use super::boxes::{Bounds, Item, SetBounds};
use crate::geometry::lanes::Four;
use crate::parallel::{exchange, map, map_parts, parts};
use crate::primitives::TriangleBlock;

/// Bins of an axis: a few, one more for so many boxes, at most so many.
const FEWEST_BINS: usize = 4;
const BOXES_PER_BIN: usize = 20;
const MOST_BINS: usize = 32;

/// From so many items on, neighbours are counted into two sets of bins by turns.
const ALTERNATED_FROM: usize = 256;

/// Maps the centres of items to bins.
#[derive(Clone, Copy)]
struct Binning {
    low: f32x4,
    scale: f32x4,
}

impl Binning {
    fn of(centres: &Bounds, bins: usize) -> Self {
        let [low, _] = centres.corners();
        let extent = (-centres.negated_extent()).to_array();
        // the last bin ends a little behind the last centre; no bins are on an axis along which all
        // are alike
        let scale = |extent: f32| if extent > 1e-30 { bins as f32 * 0.9999 / extent } else { 0.0 };
        let [x, y, z, _] = extent;
        Self { low, scale: f32x4::of_axes([x, y, z].map(scale)) }
    }

    #[inline(always)]
    fn bins(&self, centre: &Bounds) -> [i32; 4] {
        let [centre, _] = centre.corners();
        let places: i32x4 = ((centre - self.low) * self.scale).truncate();
        places.to_array()
    }
}

/// Contents of the bins of each axis.
pub(super) struct Bins {
    bounds: [[Bounds; MOST_BINS]; 3],
    /// How many boxes, of each axis in a lane of its own.
    numbers: [[i32; 4]; MOST_BINS],
}

impl Bins {
    pub(super) const NONE: Self =
        Self { bounds: [[Bounds::NONE; MOST_BINS]; 3], numbers: [[0; 4]; MOST_BINS] };

    /// The same as [`Bins::fill`], on all threads.
    #[cold]
    #[inline(never)]
    fn fill_in_parts(&mut self, count: usize, binning: &Binning, items: &[Item]) {
        let parts = map_parts(items.len(), |part| {
            let mut bins = Self::NONE;
            bins.fill(count, binning, &items[part.start as usize..part.end as usize]);
            bins
        });
        *self = Self::NONE;
        parts.iter().for_each(|part| self.join(part));
    }

    /// Counts the items into so many bins.
    #[inline(always)]
    fn fill(&mut self, count: usize, binning: &Binning, items: &[Item]) {
        self.bounds.iter_mut().for_each(|of_axis| of_axis[..count].fill(Bounds::NONE));
        self.numbers[..count].fill([0; 4]);
        if items.len() < ALTERNATED_FROM {
            items.iter().for_each(|item| self.count(binning, item));
            return;
        }
        // neighbours are often in one bin, and a bin waits for what was last added to it
        let mut others = Self::NONE;
        let (pairs, last) = items.as_chunks::<2>();
        for [one, other] in pairs {
            self.count(binning, one);
            others.count(binning, other);
        }
        last.iter().for_each(|item| self.count(binning, item));
        self.join(&others);
    }

    #[inline(always)]
    fn count(&mut self, binning: &Binning, item: &Item) {
        let places = binning.bins(&item.centre());
        for (axis, bounds) in self.bounds.iter_mut().enumerate() {
            let bin = places[axis] as usize & (MOST_BINS - 1);
            bounds[bin].add(&item.0);
            self.numbers[bin][axis] += item.boxes() as i32;
        }
    }

    fn join(&mut self, other: &Self) {
        let bounds = self.bounds.as_flattened_mut().iter_mut().zip(other.bounds.as_flattened());
        bounds.for_each(|(bounds, more)| bounds.add(more));
        let numbers = self.numbers.as_flattened_mut().iter_mut().zip(other.numbers.as_flattened());
        numbers.for_each(|(number, more)| *number += more);
    }
}

/// Of each axis the boxes on one side of a cut.
struct Side {
    around: [Bounds; 3],
    boxes: i32x4,
}

impl Side {
    const NONE: Self = Self { around: [Bounds::NONE; 3], boxes: i32x4::splat(0) };

    #[inline(always)]
    fn add(&mut self, bins: &Bins, bin: usize) {
        let axes = self.around.iter_mut().zip(&bins.bounds);
        axes.for_each(|(around, bounds)| around.add(&bounds[bin]));
        self.boxes += i32x4::new(bins.numbers[bin]);
    }

    /// The half area times the blocks.
    #[inline(always)]
    fn costs(&self) -> f32x4 {
        let [a, b, c] = self.around.each_ref().map(Bounds::negated_extent);
        let [x, y, z, _] = f32x4::transpose([a, b, c, c]);
        let blocks = (self.boxes + (BLOCK - 1)) >> BLOCK.trailing_zeros();
        (x * y + y * z + z * x) * f32x4::from_i32(blocks)
    }
}

/// Triangles of a block, a power of two.
const BLOCK: i32 = TriangleBlock::<f32>::LANES as i32;
const _: () = assert!(BLOCK.count_ones() == 1);

/// A cut between two bins.
pub(super) struct BinSplit {
    binning: Binning,
    axis: usize,
    /// The first bin of the upper side.
    bin: i32,
    /// Around the items of the lower and of the upper side.
    sides: [Bounds; 2],
}

impl BinSplit {
    /// The cut that costs least; none where all centres are alike.
    pub(super) fn of(items: &[Item], centres: &Bounds, bins: &mut Bins) -> Option<Self> {
        let count = (FEWEST_BINS + items.len() / BOXES_PER_BIN).min(MOST_BINS);
        let binning = Binning::of(centres, count);
        match parts(items.len()) {
            1 => bins.fill(count, &binning, items),
            _ => bins.fill_in_parts(count, &binning, items),
        }
        let mut side = Side::NONE;
        let mut above = [f32x4::splat(0.0); MOST_BINS];
        for bin in (1..count).rev() {
            side.add(bins, bin);
            above[bin] = side.costs();
        }
        let mut side = Side::NONE;
        let (mut least, mut best) = (f32x4::splat(f32::INFINITY), f32x4::splat(0.0));
        for (bin, &above) in (1..).zip(&above[1..count]) {
            side.add(bins, bin - 1);
            let costs = above + side.costs();
            // not where all centres are alike: what has no boxes has no area, and costs no number
            let is_less = costs.simd_lt(least);
            least = is_less.select(costs, least);
            best = is_less.select(f32x4::splat(bin as f32), best);
        }
        let (least, best) = (least.to_array(), best.to_array());
        let mut axis = 0;
        for other in 1..3 {
            if least[other] < least[axis] {
                axis = other;
            }
        }
        if least[axis] == f32::INFINITY {
            return None;
        }
        let bin = best[axis] as usize;
        let around = |bins: &[Bounds]| {
            bins.iter().fold(Bounds::NONE, |mut all, bin| {
                all.add(bin);
                all
            })
        };
        let (lower, upper) = bins.bounds[axis][..count].split_at(bin);
        Some(Self { binning, axis, bin: bin as i32, sides: [around(lower), around(upper)] })
    }

    /// Brings the items of the lower side before the others: how many they are, and what is around
    /// both. In which order the items of a side are depends on the number of threads.
    pub(super) fn partition(&self, items: &mut [Item]) -> (usize, [SetBounds; 2]) {
        let (middle, centres) = match parts(items.len()) {
            1 => self.partition_alone(items),
            parts => self.partition_in_parts(items, items.len().div_ceil(parts)),
        };
        let side = |k: usize| SetBounds { items: self.sides[k], centres: centres[k] };
        (middle, [side(0), side(1)])
    }

    /// Of the items of this thread the middle, and what is around the centres of both sides.
    /// Without branches (N. Lomuto's way to partition), as no processor can guess on which side an
    /// item is.
    fn partition_alone(&self, items: &mut [Item]) -> (usize, [Bounds; 2]) {
        let [mut lower, mut upper] = [Bounds::NONE; 2];
        let mut middle = 0;
        for i in 0..items.len() {
            let item = items[i];
            let centre = item.centre();
            let from_middle = self.binning.bins(&centre)[self.axis] - self.bin;
            items[i] = items[middle];
            items[middle] = item;
            middle += (from_middle as u32 >> 31) as usize;
            lower.add_if_negative(from_middle, &centre);
            upper.add_if_negative(!from_middle, &centre);
        }
        (middle, [lower, upper])
    }

    /// The same on all threads: each part by itself, then the items that are on the wrong side of
    /// the middle of all change places.
    #[cold]
    #[inline(never)]
    fn partition_in_parts(&self, items: &mut [Item], size: usize) -> (usize, [Bounds; 2]) {
        let mut parts: Vec<&mut [Item]> = items.chunks_mut(size).collect();
        let divided = map(&mut parts, &|part| self.partition_alone(part));
        let middle: usize = divided.iter().map(|(own_middle, _)| own_middle).sum();
        let mut sides = [Bounds::NONE; 2];
        let (mut lower, mut upper) = (Vec::new(), Vec::new());
        let parts = parts.into_iter().zip((0..).step_by(size));
        for ((part, first), (own_middle, around)) in parts.zip(divided) {
            sides.iter_mut().zip(&around).for_each(|(side, around)| side.add(around));
            let (below, above) = part.split_at_mut(own_middle);
            let in_front = |from: usize, n: usize| middle.saturating_sub(from).min(n);
            let right_below = in_front(first, below.len());
            let wrong_above = in_front(first + own_middle, above.len());
            lower.push(&mut below[right_below..]);
            upper.push(&mut above[..wrong_above]);
        }
        exchange(lower, upper);
        (middle, sides)
    }
}
