//! How an octree is built: where cells are cut, and when they are not; the octants of the first
//! cells at once.

use rayon::prelude::*;

use crate::geometry::aabb::Aabb;
use crate::geometry::scalar::{Scalar, Vec3, Vector};
use crate::memory::Counted;
use crate::parallel::{forks, is_worth_a_fork};
use crate::params::config::Settings;
use crate::room::Room;
use crate::structure::BuildError;
use crate::structures::octree::OctreeConfig;
use crate::structures::octree::cells::{Cells, LEAF};

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
        room: Room::new(
            settings.limits(),
            [(&CELLS, settings.max_cells), (&REFERENCES, settings.max_references)],
        ),
    };
    let root = || {
        let mut ids: Vec<u32> = (0..boxes.len() as u32).collect();
        if settings.order.is_reversed {
            ids.reverse();
        }
        Task { ids, bounds, depth: 0, descent: Descent::ROOT }
    };
    match forks() {
        0 => rules.alone(root()),
        // each divides by eight; which limit is broken, and by how much, is what one thread finds
        forks => rules.forked(root(), forks.div_ceil(3)).or_else(|_| rules.alone(root())),
    }
}

/// A link, and the planes of an eighth of a divided cell or the start of a list.
static CELLS: Counted = Counted::cells("number of cells", 8);
static REFERENCES: Counted = Counted::references("references in cells");

/// What does not change during a build.
struct Rules<'a, S: Scalar> {
    boxes: &'a [Aabb<S>],
    /// If `historical`, as fitted to the figures of 1999: candidates for cuts and their costs are rounded to f32,
    /// and faces across the axis only count half.
    config: &'a OctreeConfig,
    max_growth: f64,
    room: Room,
}

/// What the cuts on the way to a cell brought.
#[derive(Debug, Clone, Copy)]
struct Descent {
    /// How many failed to lower the expected cost.
    useless: u64,
    /// The product of what each multiplied the references by. While it is at most `g`, all cells
    /// together have at most `g` references to each primitive, on average.
    growth: f64,
}

impl Descent {
    const ROOT: Self = Self { useless: 0, growth: 1.0 };
}

/// A cell that is to be divided, by itself.
struct Task<S: Scalar> {
    ids: Vec<u32>,
    bounds: Aabb<S>,
    depth: u64,
    descent: Descent,
}

impl<S: Scalar> Cells<S> {
    /// A first cell without anything yet.
    fn begun() -> Self {
        Self { links: vec![LEAF], planes: Vec::new(), starts: vec![0], ids: Vec::new() }
    }

    /// Puts the cells below octant `octant` of the first cell, which is divided, behind all others.
    fn append(&mut self, octant: usize, below: &Self) {
        let (inner, leaves) = (self.planes.len() as u32, self.starts.len() as u32 - 1);
        let moved = |link: &u32| if link & LEAF != 0 { link + leaves } else { link + inner };
        if let Some(first) = below.links.first() {
            self.links[1 + octant] = moved(first);
        }
        self.links.extend(below.links.iter().skip(1).map(moved));
        self.planes.extend_from_slice(&below.planes);
        let ids = self.ids.len() as u32;
        self.starts.extend(below.starts.iter().skip(1).map(|start| start + ids));
        self.ids.extend_from_slice(&below.ids);
    }
}

struct Builder<'a, S: Scalar> {
    rules: &'a Rules<'a, S>,
    cells: Cells<S>,
    /// References of the cells on the way from the first, one list after the other.
    waiting: Vec<u32>,
}

impl<S: Scalar> Builder<'_, S> {
    /// Makes `cell` of the references `waiting[from..]`, which it takes away.
    fn cell(
        &mut self,
        cell: usize,
        bounds: Aabb<S>,
        depth: u64,
        from: usize,
        descent: Descent,
    ) -> Result<(), BuildError> {
        let end = self.waiting.len();
        let divided = self.rules.divided(&self.waiting[from..], &bounds, depth, descent);
        let Some((planes, descent)) = divided else { return self.leaf(cell, from) };
        let inner = self.cells.planes.len();
        self.rules.room.check([8 * inner as u64 + 9, self.cells.ids.len() as u64])?;
        self.cells.links[cell] = inner as u32;
        self.cells.planes.push(planes);
        self.cells.links.resize(9 + 8 * inner, LEAF);
        for octant in 0..8 {
            for i in from..end {
                let i = if self.rules.config.order.alternates { from + end - 1 - i } else { i };
                let id = self.waiting[i];
                if touches(&self.rules.boxes[id as usize], &planes, octant) {
                    self.waiting.push(id);
                }
            }
            let child = octant_of(&bounds, &planes, octant);
            self.cell(1 + 8 * inner + octant, child, depth + 1, end, descent)?;
        }
        self.waiting.truncate(from);
        Ok(())
    }

    fn leaf(&mut self, cell: usize, from: usize) -> Result<(), BuildError> {
        let references = self.cells.ids.len() + self.waiting.len() - from;
        self.rules.room.check([self.cells.links.len() as u64, references as u64])?;
        self.cells.links[cell] = LEAF | (self.cells.starts.len() - 1) as u32;
        self.cells.ids.extend_from_slice(&self.waiting[from..]);
        self.cells.starts.push(references as u32);
        self.waiting.truncate(from);
        Ok(())
    }
}

impl<S: Scalar> Rules<'_, S> {
    /// The cells below a task, on this thread.
    fn alone(&self, task: Task<S>) -> Result<Cells<S>, BuildError> {
        let mut builder = Builder { rules: self, cells: Cells::begun(), waiting: task.ids };
        builder.cell(0, task.bounds, task.depth, 0, task.descent)?;
        Ok(builder.cells)
    }

    /// The same with all octants at once, `forks` times one below the other.
    fn forked(&self, task: Task<S>, forks: u32) -> Result<Cells<S>, BuildError> {
        if forks == 0 || !is_worth_a_fork(task.ids.len()) {
            return self.alone(task);
        }
        let divided = self.divided(&task.ids, &task.bounds, task.depth, task.descent);
        let Some((planes, descent)) = divided else { return self.alone(task) };
        let below = |octant: usize| {
            let inside = |id: &u32| touches(&self.boxes[*id as usize], &planes, octant);
            let mut ids: Vec<u32> = task.ids.iter().copied().filter(inside).collect();
            if self.config.order.alternates {
                ids.reverse();
            }
            let bounds = octant_of(&task.bounds, &planes, octant);
            self.forked(Task { ids, bounds, depth: task.depth + 1, descent }, forks - 1)
        };
        let all: Vec<Result<Cells<S>, BuildError>> = (0..8).into_par_iter().map(below).collect();
        let mut cells = Cells::begun();
        cells.links = vec![LEAF; 9];
        cells.links[0] = 0;
        cells.planes.push(planes);
        for (octant, below) in all.into_iter().enumerate() {
            cells.append(octant, &below?);
        }
        self.room.check([cells.links.len() as u64, cells.ids.len() as u64])?;
        Ok(cells)
    }

    /// The planes that divide a cell, and the way to what is below it; `None` makes it a leaf.
    fn divided(
        &self,
        ids: &[u32],
        bounds: &Aabb<S>,
        depth: u64,
        descent: Descent,
    ) -> Option<([S; 3], Descent)> {
        if ids.len() <= self.config.max_leaf || depth == self.config.max_depth {
            return None;
        }
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

    /// Of eleven planes from the cell's centre to the mean centre of what is in it, the one with
    /// the least sum of area times references on both sides; of equal ones the first.
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
    let mut inside = true;
    for k in 0..3 {
        inside &= if octant >> k & 1 == 1 { hi[k] >= planes[k] } else { lo[k] <= planes[k] };
    }
    inside
}

fn octant_of<S: Scalar>(bounds: &Aabb<S>, planes: &[S; 3], octant: usize) -> Aabb<S> {
    let (mut lo, mut hi) = (bounds.min.to_array(), bounds.max.to_array());
    for k in 0..3 {
        if octant >> k & 1 == 1 { lo[k] = planes[k] } else { hi[k] = planes[k] }
    }
    Aabb { min: Vec3::<S>::from_array(lo), max: Vec3::<S>::from_array(hi) }
}
