//! Divides a set of boxes between two of equal bins of their centres, where the surface-area
//! heuristic is least.

use wide::{f32x4, i32x4};

use super::boxes::{Bounds, Item, SetBounds};
use crate::bvh::collapse::blocks;
use crate::geometry::lanes::Four;
use crate::parallel::{exchange, map, map_parts, parts};

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
        let [low, negated] = centres.corners();
        let extent = (-negated - low).to_array();
        // the last bin ends a little behind the last centre; no bins are on an axis along which all
        // are alike
        let scale = |extent: f32| if extent > 1e-30 { bins as f32 * 0.9999 / extent } else { 0.0 };
        let [x, y, z, _] = extent;
        Self { low, scale: f32x4::new([scale(x), scale(y), scale(z), 0.0]) }
    }

    #[inline(always)]
    fn bins(&self, centre: &Bounds) -> [i32; 4] {
        let [centre, _] = centre.corners();
        let places: i32x4 = (((centre - self.low) & XYZ) * self.scale).truncate();
        places.to_array()
    }
}

/// All ones for the axes. What else is there may be a subnormal number, slow to multiply on some
/// processors.
const XYZ: f32x4 =
    f32x4::new([f32::from_bits(u32::MAX), f32::from_bits(u32::MAX), f32::from_bits(u32::MAX), 0.0]);

/// Contents of the bins of each axis.
pub(super) struct Bins {
    bounds: [[Bounds; MOST_BINS]; 3],
    numbers: [[u32; MOST_BINS]; 3],
}

impl Bins {
    pub(super) const NONE: Self =
        Self { bounds: [[Bounds::NONE; MOST_BINS]; 3], numbers: [[0; MOST_BINS]; 3] };

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
        self.numbers.iter_mut().for_each(|of_axis| of_axis[..count].fill(0));
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
        let axes = self.bounds.iter_mut().zip(&mut self.numbers);
        for ((bounds, numbers), place) in axes.zip(binning.bins(&item.centre())) {
            let bin = place as usize & (MOST_BINS - 1);
            bounds[bin].add(&item.0);
            numbers[bin] += item.boxes();
        }
    }

    fn join(&mut self, other: &Self) {
        let bounds = self.bounds.as_flattened_mut().iter_mut().zip(other.bounds.as_flattened());
        bounds.for_each(|(bounds, more)| bounds.add(more));
        let numbers = self.numbers.as_flattened_mut().iter_mut().zip(other.numbers.as_flattened());
        numbers.for_each(|(number, more)| *number += more);
    }
}

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
        let blocks = |items: u32| blocks(items) as f32;
        let (mut least, mut best) = (f32::INFINITY, None);
        for axis in 0..3 {
            let (bounds, numbers) = (&bins.bounds[axis][..count], &bins.numbers[axis][..count]);
            let mut above = [0.0; MOST_BINS];
            let (mut around, mut n) = (Bounds::NONE, 0);
            for bin in (1..count).rev() {
                around.add(&bounds[bin]);
                n += numbers[bin];
                above[bin] = around.half_area() * blocks(n);
            }
            // all centres are alike; else the first and the last bin have items
            if n == 0 {
                continue;
            }
            let (mut around, mut n) = (Bounds::NONE, 0);
            for bin in 1..count {
                around.add(&bounds[bin - 1]);
                n += numbers[bin - 1];
                let cost = above[bin] + around.half_area() * blocks(n);
                if cost < least {
                    (least, best) = (cost, Some((axis, bin)));
                }
            }
        }
        let (axis, bin) = best?;
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
