//! The surface-area heuristic: what a cut is expected to cost, and which one costs least.
//!
//! A ray through a cell meets a part of it with the probability of the ratio of surfaces. Cells
//! with few references try both sides of every box (Wald, Havran 2006), others the borders of
//! equal bins and the planes that cut off empty space at either end (Shevtsov et al. 2007).

use std::cmp::Ordering;

use crate::config;
use crate::geometry::aabb::Aabb;
use crate::geometry::scalar::{Scalar, Vector};
use crate::parallel::map_parts;
use crate::params::{ParamSpec, specs};
use crate::query::{kernel, mailbox};

/// Deepest cell; the root has depth 0.
pub(super) const DEEPEST: usize = 48;

config! {
    /// How a k-d tree is built.
    pub struct KdTreeConfig {
        /// depth of the smallest cells; 0 for 8 + 1.3 log2(primitives)
        pub(super) max_depth: usize = ParamSpec::integer("max-depth", "0", 0, DEEPEST as u64),
        /// a cell with at most this many references is not cut
        pub(super) max_leaf: usize = ParamSpec::integer("max-leaf", "1", 0, 1 << 20),
        /// cost of going through an inner cell, in tests of primitives
        pub(super) traversal_cost: f64 = ParamSpec::real("traversal-cost", "1", 0.0, 1e6),
        /// part of the cost that a cut which makes an empty cell is spared
        pub(super) empty_bonus: f64 = ParamSpec::real("empty-bonus", "0.2", 0.0, 0.99),
        /// cuts in one line of descent that may fail to lower the expected cost
        pub(super) useless_splits: u64 = ParamSpec::integer("useless-splits", "2", 0, DEEPEST as u64),
        /// cells with at most this many references try every side of every box; larger ones 32
        /// planes per axis
        pub(super) exact_below: usize = ParamSpec::integer("exact-below", "64", 0, 1 << 32),
        pub(super) max_cells: u64 = specs::max_cells(specs::MAX_CELLS.default, 1 << 29),
        pub(super) max_references: u64 = specs::max_references("268435456", (1 << 31) - 1),
    }
    and kernel::PARAM, mailbox::PARAM, mailbox::SLOTS_PARAM
}

/// A plane that cuts a cell.
#[derive(Debug, Clone, Copy)]
pub(super) struct CutPlane<S> {
    pub(super) axis: usize,
    pub(super) plane: S,
    /// Expected tests of primitives for a ray through the cell.
    pub(super) cost: f64,
}

const BINS: usize = 32;

/// The settings, and memory that is used again for each cell.
pub(super) struct Heuristic<'a, S> {
    config: &'a KdTreeConfig,
    lower_sides: Vec<S>,
    upper_sides: Vec<S>,
}

impl<'a, S: Scalar> Heuristic<'a, S> {
    pub(super) fn new(config: &'a KdTreeConfig) -> Self {
        Self { config, lower_sides: Vec::new(), upper_sides: Vec::new() }
    }

    /// The cut of least cost strictly within the cell; of equal ones the first.
    pub(super) fn best_cut(
        &mut self,
        boxes: &[Aabb<S>],
        ids: &[u32],
        cell: &Aabb<S>,
    ) -> Option<CutPlane<S>> {
        let mut best = None;
        for axis in 0..3 {
            let mut trial = Trial::new(self.config, cell, axis, &mut best);
            if ids.len() <= self.config.exact_below {
                self.sweep(boxes, ids, &mut trial);
            } else {
                bins(boxes, ids, &mut trial);
            }
        }
        best
    }

    /// Tries both sides of every box.
    fn sweep(&mut self, boxes: &[Aabb<S>], ids: &[u32], trial: &mut Trial<S>) {
        let axis = trial.axis;
        let sides = |of: fn(&Aabb<S>) -> S::Vec3| {
            ids.iter().map(move |&id| of(&boxes[id as usize]).to_array()[axis])
        };
        self.lower_sides.clear();
        self.lower_sides.extend(sides(|b| b.min));
        self.upper_sides.clear();
        self.upper_sides.extend(sides(|b| b.max));
        let by_value = |a: &S, b: &S| a.partial_cmp(b).unwrap_or(Ordering::Equal);
        self.lower_sides.sort_unstable_by(by_value);
        self.upper_sides.sort_unstable_by(by_value);
        // both lists are gone through together, in ascending order of planes
        let (lows, highs) = (&self.lower_sides, &self.upper_sides);
        let (mut begun, mut ended) = (0, 0);
        while ended < highs.len() {
            let plane = match lows.get(begun) {
                Some(&low) if low < highs[ended] => low,
                _ => highs[ended],
            };
            while ended < highs.len() && highs[ended] <= plane {
                ended += 1;
            }
            // begun: those that begin strictly below; ended: those that end at or below
            trial.plane(plane, begun, ids.len() - ended);
            while begun < lows.len() && lows[begun] <= plane {
                begun += 1;
            }
        }
    }
}

/// Sorted starts and ends of boxes on an axis of a cell.
struct EdgeLists<S> {
    /// Number of starts per bin.
    begin: [usize; BINS],
    end: [usize; BINS],
    lowest: S,
    highest: S,
}

impl<S: Scalar> EdgeLists<S> {
    fn and(mut self, other: Self) -> Self {
        let both = self.begin.iter_mut().chain(&mut self.end);
        both.zip(other.begin.into_iter().chain(other.end)).for_each(|(n, more)| *n += more);
        self.lowest = other.lowest.lesser(self.lowest);
        self.highest = other.highest.greater(self.highest);
        self
    }
}

/// Tries the borders of equal bins, and the planes beyond which there is nothing.
fn bins<S: Scalar>(boxes: &[Aabb<S>], ids: &[u32], trial: &mut Trial<S>) {
    let (axis, lo, hi) = (trial.axis, trial.lo, trial.hi);
    let scale = S::from_i32(BINS as i32) / (hi - lo);
    let bin = |x: S| ((x - lo) * scale).to_i32().clamp(0, BINS as i32 - 1) as usize;
    let none = || EdgeLists { begin: [0; BINS], end: [0; BINS], lowest: hi, highest: lo };
    let ends = map_parts(ids.len(), |part| {
        let mut ends = none();
        for &id in &ids[part.start as usize..part.end as usize] {
            let b = &boxes[id as usize];
            let (a, z) = (b.min.to_array()[axis], b.max.to_array()[axis]);
            ends.begin[bin(a)] += 1;
            ends.end[bin(z)] += 1;
            ends.lowest = a.lesser(ends.lowest);
            ends.highest = z.greater(ends.highest);
        }
        ends
    });
    let EdgeLists { begin, end, lowest, highest } = ends.into_iter().fold(none(), EdgeLists::and);
    trial.plane(lowest, 0, ids.len());
    trial.plane(highest, ids.len(), 0);
    let (mut below, mut above) = (0, ids.len());
    for i in 1..BINS {
        below += begin[i - 1];
        above -= end[i - 1];
        trial.plane(lo + (hi - lo) * S::from_f64(i as f64 / BINS as f64), below, above);
    }
}

/// Planes of one axis of a cell on trial.
struct Trial<'a, S> {
    axis: usize,
    lo: S,
    hi: S,
    /// Surface of the two faces across the axis, and of the others per length of the axis.
    caps: f64,
    girth: f64,
    /// One over the cell's surface.
    scale: f64,
    config: &'a KdTreeConfig,
    best: &'a mut Option<CutPlane<S>>,
}

impl<'a, S: Scalar> Trial<'a, S> {
    fn new(
        config: &'a KdTreeConfig,
        cell: &Aabb<S>,
        axis: usize,
        best: &'a mut Option<CutPlane<S>>,
    ) -> Self {
        let size = cell.size().to_dvec3();
        let (u, v) = (size[(axis + 1) % 3], size[(axis + 2) % 3]);
        let (caps, girth) = (u * v, u + v);
        Self {
            axis,
            lo: cell.min.to_array()[axis],
            hi: cell.max.to_array()[axis],
            caps,
            girth,
            scale: 1.0 / (caps + girth * size[axis]).max(f64::MIN_POSITIVE),
            config,
            best,
        }
    }

    /// Tries a plane with so many references on either side of it.
    fn plane(&mut self, plane: S, below: usize, above: usize) {
        let cuts = self.lo < plane && plane < self.hi;
        if !cuts {
            return;
        }
        let surface = |length: S| self.caps + self.girth * length.to_f64();
        let tests =
            surface(plane - self.lo) * below as f64 + surface(self.hi - plane) * above as f64;
        let bonus = if below == 0 || above == 0 { 1.0 - self.config.empty_bonus } else { 1.0 };
        let cost = bonus * (self.config.traversal_cost + tests * self.scale);
        if self.best.is_none_or(|b| cost < b.cost) {
            *self.best = Some(CutPlane { axis: self.axis, plane, cost });
        }
    }
}
