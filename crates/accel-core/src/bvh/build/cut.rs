//! Divides a set of boxes between two of equal bins of their centres, where the surface-area
//! heuristic is least.

use wide::{f32x4, i32x4};

use super::boxes::{Bounds, Item, SetBounds};
use crate::bvh::collapse::blocks;
use crate::geometry::lanes::Four;
use crate::parallel::{map_parts, parts};

/// Bins of an axis: a few, one more for so many boxes, at most so many.
const FEWEST_BINS: usize = 4;
const BOXES_PER_BIN: usize = 20;
const MOST_BINS: usize = 32;

/// Maps the centres of items to bins.
#[derive(Clone, Copy)]
struct Binning {
    low: f32x4,
    scale: f32x4,
}

impl Binning {
    fn of(centres: &Bounds, bins: usize) -> Self {
        let extent = (centres.high - centres.low).to_array();
        // the last bin ends a little behind the last centre; no bins are on an axis along which all
        // are alike
        let scale = |extent: f32| if extent > 1e-30 { bins as f32 * 0.9999 / extent } else { 0.0 };
        let [x, y, z, _] = extent;
        Self { low: centres.low, scale: f32x4::new([scale(x), scale(y), scale(z), 0.0]) }
    }

    #[inline(always)]
    fn bins(&self, item: &Item) -> [i32; 4] {
        let places: i32x4 = ((item.centre() - self.low) * self.scale).truncate();
        places.to_array()
    }
}

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
        for part in parts {
            for axis in 0..3 {
                let bounds = self.bounds[axis].iter_mut().zip(&part.bounds[axis]);
                bounds.for_each(|(bounds, more)| bounds.add(more));
                let numbers = self.numbers[axis].iter_mut().zip(&part.numbers[axis]);
                numbers.for_each(|(number, more)| *number += more);
            }
        }
    }

    /// Counts the items into so many bins.
    #[inline(always)]
    fn fill(&mut self, count: usize, binning: &Binning, items: &[Item]) {
        self.bounds.iter_mut().for_each(|of_axis| of_axis[..count].fill(Bounds::NONE));
        self.numbers.iter_mut().for_each(|of_axis| of_axis[..count].fill(0));
        for item in items {
            let axes = self.bounds.iter_mut().zip(&mut self.numbers);
            for ((bounds, numbers), place) in axes.zip(binning.bins(item)) {
                let bin = place as usize & (MOST_BINS - 1);
                bounds[bin].add(&item.0);
                numbers[bin] += item.boxes();
            }
        }
    }
}

/// A cut between two bins.
pub(super) struct BinSplit {
    binning: Binning,
    axis: usize,
    /// The first bin of the upper side.
    bin: i32,
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
                    (least, best) = (cost, Some(Self { binning, axis, bin: bin as i32 }));
                }
            }
        }
        best
    }

    /// Brings the items of the lower side before the others: how many they are, and what is around
    /// both. Without branches (N. Lomuto's way to partition), as no processor can guess on which
    /// side an item is.
    pub(super) fn partition(&self, items: &mut [Item]) -> (usize, [SetBounds; 2]) {
        let [mut lower, mut upper] = [SetBounds::NONE; 2];
        let mut middle = 0;
        for i in 0..items.len() {
            let item = items[i];
            let is_lower = self.binning.bins(&item)[self.axis] < self.bin;
            items[i] = items[middle];
            items[middle] = item;
            middle += usize::from(is_lower);
            let mask = i32x4::splat(-i32::from(is_lower));
            lower.add_where(mask, &item);
            upper.add_where(!mask, &item);
        }
        (middle, [lower, upper])
    }
}
