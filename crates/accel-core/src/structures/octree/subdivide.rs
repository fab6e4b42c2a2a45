//! Chooses the cuts of octree cells (`tree/build.rs` builds them).

use crate::capacity::CapacityLimits;
use crate::geometry::aabb::Aabb;
use crate::geometry::scalar::{Scalar, Vec3, Vector};
use crate::memory::CountedItem;
use crate::params::config::Settings;
use crate::structure::BuildError;
use crate::structures::octree::config::OctreeConfig;
use crate::tree::build::{self, Cell, Division, Link};

/// Builds the cells over boxes of primitives, on all threads of the current rayon pool; the same
/// cells in the same places for any number of threads.
pub(super) fn cells<S: Scalar>(
    boxes: &[Aabb<S>],
    bounds: Aabb<S>,
    settings: &Settings<OctreeConfig>,
) -> Result<Cells<S>, BuildError> {
    let rules = Rules {
        boxes,
        config: settings,
        max_growth: if settings.historical { f64::INFINITY } else { settings.max_growth },
        room: CapacityLimits::new(
            settings.limits(),
            [(&CELLS, settings.max_cells), (&REFERENCES, settings.max_references)],
        ),
    };
    let root = Cell { bounds, depth: 0, descent: Descent { useless: 0, growth: 1.0 } };
    let mut ids: Vec<u32> = (0..boxes.len() as u32).collect();
    if settings.order.is_reversed {
        ids.reverse();
    }
    build::cells(&rules, root, ids)
}

/// A link, and the planes of an eighth of a divided cell or the start of a list.
static CELLS: CountedItem = CountedItem::cells("number of cells", 8);
static REFERENCES: CountedItem = CountedItem::references("references in cells");

/// The cells, with bit k of a child's place set on the upper side of axis k.
pub(super) type Cells<S> = build::Cells<S, OctantLink>;

/// The number of a leaf with [`LEAF`] set, or that of an inner cell, of which the planes are kept.
#[derive(Debug, Clone, Copy)]
pub(super) struct OctantLink(u32);

/// Set in the link of a leaf.
const LEAF: u32 = 1 << 31;

/// The kind of a cell.
pub(super) enum Content<'a, S> {
    /// Cut by these planes; the first of its eight children.
    Inner(&'a [S; 3], u32),
    Leaf(&'a [u32]),
}

impl<S: Scalar> Cells<S> {
    #[inline(always)]
    pub(super) fn content(&self, cell: u32) -> Content<'_, S> {
        let OctantLink(link) = self.links[cell as usize];
        let number = (link & !LEAF) as usize;
        if link & LEAF == 0 {
            Content::Inner(&self.cuts[number], 1 + 8 * link)
        } else {
            Content::Leaf(self.lists.at(number))
        }
    }
}

/// Settings that stay constant during a build.
struct Rules<'a, S: Scalar> {
    boxes: &'a [Aabb<S>],
    /// If `historical`, as fitted to the figures of 1999: candidates for cuts and their costs are
    /// rounded to f32, and faces across the axis only count half.
    config: &'a OctreeConfig,
    max_growth: f64,
    room: CapacityLimits,
}

/// Statistics of the cuts on the path to a cell.
#[derive(Debug, Clone, Copy)]
struct Descent {
    /// Number of cuts that did not lower the expected cost.
    useless: u64,
    /// The product of what each multiplied the references by. While it is at most `g`, all cells
    /// together have at most `g` references to each primitive, on average.
    growth: f64,
}

impl<S: Scalar> Link<S> for OctantLink {
    type Cut = [S; 3];
    type Record = [S; 3];
    const CHILDREN: usize = 8;

    fn leaf(number: u32) -> Self {
        Self(LEAF | number)
    }

    fn inner(_: &[S; 3], number: u32) -> Self {
        Self(number)
    }

    fn record(planes: [S; 3]) -> [S; 3] {
        planes
    }

    fn moved(self, by: [u32; 2]) -> Self {
        Self(self.0 + by[usize::from(self.0 & LEAF != 0)])
    }
}

impl<S: Scalar> Division<S> for Rules<'_, S> {
    type Link = OctantLink;
    type Cut = [S; 3];
    type Descent = Descent;
    type Scratch = ();

    fn scratch(&self) {}

    fn cut(&self, (): &mut (), ids: &[u32], cell: &Cell<S, Descent>) -> Option<([S; 3], Descent)> {
        if ids.len() <= self.config.max_leaf || cell.depth == self.config.max_depth {
            return None;
        }
        let (bounds, descent) = (&cell.bounds, cell.descent);
        let planes = self.cuts(bounds, ids);
        let counts = self.counts(&planes, ids);
        let references = ids.len() as f64;
        let is_useless = expected_tests(bounds, &planes, &counts) + TRAVERSAL_COST >= references;
        let useless = descent.useless + u64::from(is_useless);
        let below: f64 = counts.iter().copied().map(f64::from).sum();
        let growth = descent.growth * below / references;
        let pays = useless <= self.config.useless_splits && growth <= self.max_growth;
        pays.then_some((planes, Descent { useless, growth }))
    }

    #[inline(always)]
    fn reaches(&self, id: u32, planes: &[S; 3], octant: usize) -> bool {
        touches(&self.boxes[id as usize], planes, octant)
    }

    fn child(bounds: &Aabb<S>, planes: &[S; 3], octant: usize) -> Aabb<S> {
        octant_of(bounds, planes, octant)
    }

    fn alternates(&self) -> bool {
        self.config.order.alternates
    }

    fn room(&self) -> &CapacityLimits {
        &self.room
    }
}

impl<S: Scalar> Rules<'_, S> {
    /// The planes that cut a cell.
    fn cuts(&self, bounds: &Aabb<S>, ids: &[u32]) -> [S; 3] {
        let half = S::from_f64(0.5);
        let (lo, hi) = (bounds.min.to_array(), bounds.max.to_array());
        std::array::from_fn(|k| {
            let centre = (lo[k] + hi[k]) * half;
            let cut =
                if self.config.adaptive { self.least_cost(bounds, ids, k, centre) } else { centre };
            cut.greater(lo[k]).lesser(hi[k])
        })
    }

    /// Finds the cheapest of eleven planes between the cell's centre and the mean centre of its
    /// contents, by the sum of area times references on both sides; the first on ties.
    fn least_cost(&self, bounds: &Aabb<S>, ids: &[u32], k: usize, centre: S) -> S {
        let rounded = |x: S| {
            if self.config.historical { S::from_f64(f64::from(x.to_f64() as f32)) } else { x }
        };
        let (lo, hi) = (bounds.min.to_array()[k], bounds.max.to_array()[k]);
        let interval = |&id: &u32| {
            let b = &self.boxes[id as usize];
            (b.min.to_array()[k], b.max.to_array()[k])
        };
        let sum: f64 = ids
            .iter()
            .map(interval)
            .map(|(a, b)| 0.5 * (a.greater(lo).to_f64() + b.lesser(hi).to_f64()))
            .sum();
        let centre = rounded(centre);
        let objects = rounded(S::from_f64(sum / ids.len().max(1) as f64));
        let step = rounded(rounded(objects - centre) / S::from_i32(CANDIDATES as i32 - 1));
        let mut candidates = [centre; CANDIDATES];
        for i in 1..CANDIDATES {
            candidates[i] = rounded(candidates[i - 1] + step);
        }
        let (mut below, mut above) = ([0u32; CANDIDATES], [0u32; CANDIDATES]);
        for (a, b) in ids.iter().map(interval) {
            for i in 0..CANDIDATES {
                below[i] += u32::from(a < candidates[i]);
                above[i] += u32::from(b > candidates[i]);
            }
        }
        let mut best = (f64::INFINITY, centre);
        for i in 0..CANDIDATES {
            let x = candidates[i];
            let cost = self.area_with_side(bounds, k, x - lo) * f64::from(below[i])
                + self.area_with_side(bounds, k, hi - x) * f64::from(above[i]);
            // so that planes that are alike by symmetry stay equal
            let cost = if self.config.historical { f64::from(cost as f32) } else { cost };
            if cost < best.0 {
                best = (cost, x);
            }
        }
        best.1
    }

    /// Half the surface of the cell when its side on axis `k` is replaced.
    fn area_with_side(&self, cell: &Aabb<S>, k: usize, side: S) -> f64 {
        let s = cell.size().to_dvec3();
        let (u, v) = (s[(k + 1) % 3], s[(k + 2) % 3]);
        let faces_across = if self.config.historical { 0.5 } else { 1.0 };
        faces_across * u * v + (u + v) * side.to_f64()
    }

    /// References of the children.
    fn counts(&self, planes: &[S; 3], ids: &[u32]) -> [u32; 8] {
        let mut counts = [0u32; 8];
        for &id in ids {
            for (octant, count) in counts.iter_mut().enumerate() {
                *count += u32::from(touches(&self.boxes[id as usize], planes, octant));
            }
        }
        counts
    }
}

/// References of the children, each weighted by the chance that a ray through the cell meets the
/// child: the ratio of their surfaces.
fn expected_tests<S: Scalar>(bounds: &Aabb<S>, planes: &[S; 3], counts: &[u32; 8]) -> f64 {
    let weighted: f64 =
        (0..8).map(|i| f64::from(counts[i]) * octant_of(bounds, planes, i).half_area()).sum();
    weighted / bounds.half_area().max(f64::MIN_POSITIVE)
}

/// Number of planes tried an axis by the adaptive subdivision.
const CANDIDATES: usize = 11;
/// Cost of going through an inner cell, in tests of primitives.
const TRAVERSAL_COST: f64 = 1.0;

/// Does the box reach into the octant? Closed on both sides: what ends on a plane is in both.
#[inline(always)]
fn touches<S: Scalar>(b: &Aabb<S>, planes: &[S; 3], octant: usize) -> bool {
    let (lo, hi) = (b.min.to_array(), b.max.to_array());
    let reaches = |k: usize| {
        if octant >> k & 1 == 1 { hi[k] >= planes[k] } else { lo[k] <= planes[k] }
    };
    reaches(0) & reaches(1) & reaches(2)
}

/// The box of a child.
pub(super) fn octant_of<S: Scalar>(bounds: &Aabb<S>, planes: &[S; 3], octant: usize) -> Aabb<S> {
    let (mut lo, mut hi) = (bounds.min.to_array(), bounds.max.to_array());
    for k in 0..3 {
        if octant >> k & 1 == 1 { lo[k] = planes[k] } else { hi[k] = planes[k] }
    }
    Aabb { min: Vec3::<S>::from_array(lo), max: Vec3::<S>::from_array(hi) }
}
