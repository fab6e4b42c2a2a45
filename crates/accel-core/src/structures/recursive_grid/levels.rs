//! One level of a recursive grid: how many voxels it gets, what goes into them, and which of them
//! are divided further.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, OnceLock, PoisonError};

use crate::aabb::Aabb;
use crate::cell_lists::{CellLists, Placement};
use crate::resolution::{ResolutionInput, ResolutionRule, resolve};
use crate::scalar::{Scalar, Vector};
use crate::voxel_walk::GridFrame;

/// Marks an entry of a list that is the index of a child, not of a primitive.
const CHILD: u32 = 1 << 31;

/// How many primitives a recursive grid can hold: their ids must leave the mark free.
pub(super) const MAX_PRIMITIVES: u64 = CHILD as u64;

/// Voxels narrower than this many ulps of the scene's largest coordinate are not made: their
/// planes could not be told apart.
const NARROWEST_VOXEL_ULPS: f64 = 64.0;

/// A grid, and the grids in its voxels.
pub(super) struct Grid<S: Scalar> {
    pub(super) frame: GridFrame<S>,
    /// Ids, or one entry with [`CHILD`] set.
    pub(super) lists: CellLists,
    pub(super) children: Vec<Child<S>>,
}

/// What a voxel holds.
pub(super) enum Voxel<'a, S: Scalar> {
    /// Primitives.
    Ids(&'a [u32]),
    /// A divided voxel.
    Child(&'a Child<S>),
}

impl<S: Scalar> Grid<S> {
    /// What the voxel with that index holds.
    #[inline(always)]
    pub(super) fn voxel(&self, index: usize) -> Voxel<'_, S> {
        let list = self.lists.list(index);
        if let Some(&first) = list.first()
            && first & CHILD != 0
            && let Some(child) = self.children.get((first & !CHILD) as usize)
        {
            return Voxel::Child(child);
        }
        Voxel::Ids(list)
    }
}

/// A voxel that holds more primitives than the threshold.
pub(super) struct Child<S: Scalar> {
    /// What it is to be built from; empty once that was done.
    waiting: Mutex<Vec<u32>>,
    content: OnceLock<Content<S>>,
}

/// What became of such a voxel.
pub(super) enum Content<S: Scalar> {
    /// It was divided.
    Grid(Grid<S>),
    /// Dividing it would not have paid, or broken a limit: an elementary voxel after all.
    List(Vec<u32>),
}

impl<S: Scalar> Child<S> {
    fn built(grid: Grid<S>) -> Self {
        Self { waiting: Mutex::default(), content: OnceLock::from(Content::Grid(grid)) }
    }

    fn waiting(ids: &[u32]) -> Self {
        Self { waiting: Mutex::new(ids.to_vec()), content: OnceLock::new() }
    }

    /// What is there, if it was ever built.
    pub(super) fn built_content(&self) -> Option<&Content<S>> {
        self.content.get()
    }

    /// How many references wait to be built from.
    pub(super) fn waiting_references(&self) -> usize {
        self.waiting.lock().unwrap_or_else(PoisonError::into_inner).len()
    }

    /// What is there; built now by the first ray that asks, while other threads that need this
    /// very voxel wait. `bounds` and `depth` are those of the voxel.
    #[inline(always)]
    pub(super) fn content(
        &self,
        division: &Division<S>,
        bounds: impl FnOnce() -> Aabb<S>,
        depth: u32,
    ) -> &Content<S> {
        self.content.get_or_init(|| {
            let ids = {
                let mut waiting = self.waiting.lock().unwrap_or_else(PoisonError::into_inner);
                std::mem::take(&mut *waiting)
            };
            match division.grid(&ids, bounds(), depth) {
                Ok(Some(grid)) => {
                    division.references.give_back(ids.len() as u64);
                    Content::Grid(grid)
                }
                Ok(None) | Err(_) => Content::List(ids),
            }
        })
    }
}

/// How the voxels of a level are counted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum LevelRule {
    /// Cubes, D a reference, flat voxels included.
    Density,
    /// s_i (D n / V)^(1/3).
    Heterogeneous,
    /// n^(1/3) on every axis, rounded up.
    CubeRoot,
}

/// A limit was exceeded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct OverLimit {
    pub(super) what: &'static str,
    pub(super) needed: u64,
    pub(super) limit: u64,
}

/// What is left of a limit; shared by the threads that build.
#[derive(Debug)]
pub(super) struct Budget {
    what: &'static str,
    limit: u64,
    left: AtomicU64,
}

impl Budget {
    pub(super) fn new(what: &'static str, limit: u64) -> Self {
        Self { what, limit, left: AtomicU64::new(limit) }
    }

    fn left(&self) -> u64 {
        self.left.load(Ordering::Relaxed)
    }

    fn exceeded_by(&self, amount: u64) -> OverLimit {
        let needed = (self.limit - self.left().min(self.limit)).saturating_add(amount);
        OverLimit { what: self.what, needed, limit: self.limit }
    }

    fn take(&self, amount: u64) -> Result<(), OverLimit> {
        self.left
            .fetch_update(Ordering::Relaxed, Ordering::Relaxed, |left| left.checked_sub(amount))
            .map(|_| ())
            .map_err(|_| self.exceeded_by(amount))
    }

    fn give_back(&self, amount: u64) {
        self.left.fetch_add(amount, Ordering::Relaxed);
    }
}

/// All that is needed to divide a voxel.
#[derive(Debug)]
pub(super) struct Division<S: Scalar> {
    /// Boxes of all primitives, as they are inserted.
    pub(super) boxes: Vec<Aabb<S>>,
    pub(super) rule: LevelRule,
    /// Voxels a reference: of the root, and of all other grids.
    pub(super) densities: [f64; 2],
    /// Voxels with more references than this are divided.
    pub(super) threshold: usize,
    /// Depth of the deepest grids; the root has depth 1.
    pub(super) max_depth: u32,
    /// Grids down to this depth are built with the structure, deeper ones on demand.
    pub(super) eager_depth: u32,
    /// A voxel is not divided if that would multiply its references by more than this.
    pub(super) max_growth: f64,
    /// Cell indices by division, as in 1999.
    pub(super) by_division: bool,
    /// No voxel is narrower.
    pub(super) narrowest: S,
    pub(super) cells: Budget,
    pub(super) references: Budget,
}

/// Bounding-box insertion.
struct BoxPlacement<'a, S: Scalar> {
    frame: GridFrame<S>,
    division: &'a Division<S>,
}

impl<S: Scalar> Placement for BoxPlacement<'_, S> {
    #[inline(always)]
    fn cells_of(&self, id: u32, mut emit: impl FnMut(usize)) {
        let b = &self.division.boxes[id as usize];
        let (first, last) = if self.division.by_division {
            self.frame.range_by_division(b)
        } else {
            self.frame.range(b)
        };
        for z in first[2]..=last[2] {
            for y in first[1]..=last[1] {
                let row = self.frame.index([0, y, z]);
                for x in first[0]..=last[0] {
                    emit(row + x as usize);
                }
            }
        }
    }
}

impl<S: Scalar> Division<S> {
    /// The smallest width of a voxel in a scene with this box.
    pub(super) fn narrowest_in(scene: Aabb<S>) -> S {
        S::EPSILON * scene.magnitude() * S::from_f64(NARROWEST_VOXEL_ULPS)
    }

    /// The outermost grid.
    pub(super) fn root(&self, ids: &[u32], bounds: Aabb<S>) -> Result<Grid<S>, OverLimit> {
        match self.grid(ids, bounds, 1)? {
            Some(root) => Ok(root),
            // never: the growth of the root is not limited
            None => Err(self.references.exceeded_by(0)),
        }
    }

    /// The grid of `bounds` over these primitives, with the grids below it that are not left for
    /// later. `None` for a grid that would not pay; the root is always made.
    pub(super) fn grid(
        &self,
        ids: &[u32],
        bounds: Aabb<S>,
        depth: u32,
    ) -> Result<Option<Grid<S>>, OverLimit> {
        let n = self.resolution(ids.len(), bounds, depth);
        if depth > 1 && n == [1; 3] {
            return Ok(None);
        }
        let frame = GridFrame::new(bounds, n);
        let cells = frame.cells() as u64;
        self.cells.take(cells)?;
        let allowed = if depth > 1 { self.max_growth * ids.len() as f64 } else { f64::INFINITY };
        let left = self.references.left();
        let placement = BoxPlacement { frame, division: self };
        let lists =
            match CellLists::build_of(frame.cells(), ids, left.min(allowed as u64), &placement) {
                Ok(lists) => lists,
                Err(needed) => {
                    self.cells.give_back(cells);
                    return if needed.0 as f64 > allowed {
                        Ok(None)
                    } else {
                        Err(self.references.exceeded_by(needed.0))
                    };
                }
            };
        self.references.take(lists.references() as u64)?;
        let mut children = Vec::new();
        let lists = if depth < self.max_depth {
            lists.replaced(|cell, list| self.child(&mut children, &frame, cell, list, depth))?
        } else {
            lists
        };
        children.shrink_to_fit();
        Ok(Some(Grid { frame, lists, children }))
    }

    /// Divides a voxel of a grid of this depth, now or later, and returns the entry that stands
    /// for it; `None` if it stays as it is.
    fn child(
        &self,
        children: &mut Vec<Child<S>>,
        frame: &GridFrame<S>,
        cell: usize,
        list: &[u32],
        depth: u32,
    ) -> Result<Option<u32>, OverLimit> {
        if list.len() <= self.threshold {
            return Ok(None);
        }
        let child = if depth < self.eager_depth {
            let Some(grid) = self.grid(list, frame.cell_bounds(cell), depth + 1)? else {
                return Ok(None);
            };
            self.references.give_back(list.len() as u64);
            Child::built(grid)
        } else {
            Child::waiting(list)
        };
        let entry = CHILD | children.len() as u32;
        children.push(child);
        Ok(Some(entry))
    }

    /// Voxels an axis for `n` references in `bounds`.
    fn resolution(&self, n: usize, bounds: Aabb<S>, depth: u32) -> [u32; 3] {
        let density = self.densities[usize::from(depth > 1)];
        let max_cells = self.cells.left().max(1);
        let rule = match self.rule {
            LevelRule::Density => ResolutionRule::Density,
            LevelRule::Heterogeneous => ResolutionRule::Heterogeneous,
            LevelRule::CubeRoot => ResolutionRule::Regular,
        };
        let input =
            ResolutionInput { bounds, primitives: n, density, mean_longest_side: 0.0, max_cells };
        let mut voxels = match self.rule {
            LevelRule::CubeRoot => [((n as f64 * density).cbrt() - 1e-6).ceil().max(1.0) as u32; 3],
            LevelRule::Heterogeneous => experiment(&input),
            // computed rules never exceed max_cells
            _ => resolve(rule, &input).unwrap_or([1; 3]),
        };
        let size = bounds.size().to_array();
        for k in 0..3 {
            let most = (size[k].to_f64() / self.narrowest.to_f64()).clamp(1.0, f64::from(u32::MAX));
            voxels[k] = voxels[k].min(most as u32);
        }
        voxels
    }
}

fn experiment<S: Scalar>(i: &ResolutionInput<S>) -> [u32; 3] {
    let size = i.bounds.size().to_array().map(|s| s.to_f64());
    let v: f64 = size.iter().product();
    let f = (i.density * i.primitives as f64 / v).cbrt();
    static MODE: std::sync::LazyLock<u32> =
        std::sync::LazyLock::new(|| std::env::var("MODE").unwrap_or_default().parse().unwrap_or(0));
    size.map(|s| {
        let x = s * f;
        let n = match *MODE {
            0 => x.floor(),
            1 => x.round(),
            2 => x.ceil(),
            3 => x.floor() + 1.0,
            4 => (x + 1e-6).floor(),
            5 => (x - 1e-6).ceil(),
            _ => x,
        };
        n.max(1.0) as u32
    })
}
