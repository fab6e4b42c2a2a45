//! One level of a recursive grid: how many voxels it gets, what goes into them, and which of them
//! are divided further.

use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};

use crate::capacity::CapacityLimits;
use crate::geometry::aabb::Aabb;
use crate::geometry::scalar::{Scalar, Vector};
use crate::grid::block_lists::{BoxPlacement, DenseRows, block_lists};
use crate::grid::cell_lists::{CellLists, ListOrder, TooManyReferences};
use crate::grid::resolution::{MAX_PER_AXIS, resolve_by_density};
use crate::grid::voxel_traversal::GridFrame;
use crate::parallel::{map, should_parallelize};
use crate::query::cells::{Cell, CellVisitor};
use crate::structures::recursive_grid::budget::{Budget, ExcessCounts};
use crate::structures::recursive_grid::config::{LevelRule, RecursiveGridConfig};

/// Marks an entry of a list that is the index of a child, not of a primitive.
const CHILD: u32 = 1 << 31;

/// Maximum number of primitives: their ids must leave the mark bit free.
pub(super) const MAX_PRIMITIVES: u64 = CHILD as u64;

/// Voxels narrower than this many ulps of the scene's largest coordinate are not made: their
/// planes could not be distinguished.
const NARROWEST_VOXEL_ULPS: f64 = 64.0;

/// The factor by which an outermost grid that would not pay is made coarser.
const ROOT_COARSENING: f64 = 8.0;

/// A grid, and the grids in its voxels.
pub(super) struct Grid<S: Scalar> {
    pub(super) frame: GridFrame<S>,
    /// Ids, or one entry with [`CHILD`] set.
    pub(super) lists: CellLists<Arc<[u32]>>,
    pub(super) children: Vec<Child<S>>,
}

/// Contents of a voxel.
pub(super) enum Voxel<'a, S: Scalar> {
    Ids(&'a [u32]),
    Child(&'a Child<S>),
}

impl<S: Scalar> Grid<S> {
    /// Contents of the voxel with this index.
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

    /// Calls `visit` with this grid and all within it that are built.
    pub(super) fn visit<'a>(&'a self, visit: &mut impl FnMut(&'a Self)) {
        visit(self);
        for child in &self.children {
            if let Some(Content::Grid(inner)) = child.built_content() {
                inner.visit(visit);
            }
        }
    }

    /// Calls `each` with this grid, its voxels and all within.
    pub(super) fn show(&self, depth: u32, each: &mut CellVisitor<'_>) {
        each(Cell::inner(self.frame.bounds(), depth));
        for index in 0..self.frame.cells() {
            let mut leaf =
                |ids: &[u32]| each(Cell::elementary(self.frame.cell_bounds(index), depth + 1, ids));
            match self.voxel(index) {
                Voxel::Ids(ids) => leaf(ids),
                Voxel::Child(child) => match child.built_content() {
                    Some(Content::Grid(inner)) => inner.show(depth + 1, each),
                    Some(Content::List(ids)) => leaf(ids),
                    None => leaf(&child.waiting()),
                },
            }
        }
    }

    fn visit_mut(&mut self, visit: &mut impl FnMut(&mut Self)) {
        visit(self);
        for child in &mut self.children {
            if let Some(Content::Grid(inner)) = child.content.get_mut() {
                inner.visit_mut(visit);
            }
        }
    }

    /// Puts the lists of all grids that are built into one array.
    pub(super) fn join_lists(&mut self) {
        let mut all = Vec::new();
        self.visit_mut(&mut |grid| grid.lists.move_to(&mut all));
        let all = Arc::from(all);
        self.visit_mut(&mut |grid| grid.lists.share(&all));
    }

    /// Calls `each` with the lists of primitives.
    pub(super) fn lists<'a>(&'a self, each: &mut dyn FnMut(&'a [u32])) {
        self.visit(&mut |grid| {
            for voxel in 0..grid.lists.cells() {
                if let Voxel::Ids(ids) = grid.voxel(voxel) {
                    each(ids);
                }
            }
        });
    }
}

/// A voxel that holds more primitives than the threshold.
pub(super) struct Child<S: Scalar> {
    /// Primitive ids to build from; empty after the build.
    waiting: Mutex<Vec<u32>>,
    content: OnceLock<Content<S>>,
}

/// Result of building a deferred voxel.
pub(super) enum Content<S: Scalar> {
    Grid(Grid<S>),
    /// Dividing it would not have paid, or broken a limit: an elementary voxel after all.
    List(Vec<u32>),
}

impl<S: Scalar> Child<S> {
    fn built(grid: Grid<S>) -> Self {
        Self { waiting: Mutex::default(), content: OnceLock::from(Content::Grid(grid)) }
    }

    fn later(ids: &[u32]) -> Self {
        Self { waiting: Mutex::new(ids.to_vec()), content: OnceLock::new() }
    }

    /// Contents, if they have been built.
    pub(super) fn built_content(&self) -> Option<&Content<S>> {
        self.content.get()
    }

    /// Primitive ids still to build from.
    pub(super) fn waiting(&self) -> MutexGuard<'_, Vec<u32>> {
        self.waiting.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Contents of the voxel; built by the first ray that needs them, while other threads wait.
    /// `bounds` and `depth` are those of the voxel.
    #[inline(always)]
    pub(super) fn content(
        &self,
        division: &Division<S>,
        bounds: impl FnOnce() -> Aabb<S>,
        depth: u32,
    ) -> &Content<S> {
        self.content.get_or_init(|| {
            let ids = std::mem::take(&mut *self.waiting());
            match division.grid(&ids, bounds(), depth) {
                Ok(Some(grid)) => {
                    division.budget.give_back([0, ids.len() as u64]);
                    Content::Grid(grid)
                }
                Ok(None) | Err(_) => Content::List(ids),
            }
        })
    }
}

/// All that is needed to divide a voxel.
#[derive(Debug)]
pub(super) struct Division<S: Scalar> {
    /// Boxes of all primitives, as they are inserted.
    pub(super) boxes: Vec<Aabb<S>>,
    /// With `boxes=historical`, cell indices are found by division.
    pub(super) config: RecursiveGridConfig,
    /// No voxel is narrower.
    pub(super) narrowest: S,
    /// By so much the grid of a voxel reaches beyond it on every side; see `voxel_traversal.rs`.
    pub(super) padding: S,
    pub(super) budget: Budget,
}

impl<S: Scalar> Division<S> {
    /// The smallest width of a voxel in a scene with this box.
    pub(super) fn narrowest_in(scene: Aabb<S>) -> S {
        S::EPSILON * scene.magnitude() * S::from_f64(NARROWEST_VOXEL_ULPS)
    }

    /// Grids down to this depth, the root's being 1, are built with the structure, deeper ones on
    /// demand.
    fn eager_depth(&self) -> u32 {
        if self.config.is_lazy { self.config.lazy_levels } else { self.config.max_depth }
    }

    /// The outermost grid, over all primitives; coarser than asked for where that would multiply
    /// references too much. Several threads make the grids that one makes.
    pub(super) fn root(
        &mut self,
        bounds: Aabb<S>,
        room: CapacityLimits,
    ) -> Result<Grid<S>, ExcessCounts> {
        if should_parallelize(self.boxes.len()) {
            self.budget = Budget::in_any_order(room);
            if let Ok(root) = self.outermost(bounds) {
                self.budget.in_order();
                return Ok(root);
            }
        }
        self.budget = Budget::new(room);
        self.outermost(bounds)
    }

    fn outermost(&self, bounds: Aabb<S>) -> Result<Grid<S>, ExcessCounts> {
        let mut density = self.config.top_density;
        loop {
            let primitives = self.boxes.len();
            let frame = GridFrame::new(bounds, self.resolution(primitives, bounds, density));
            let rows = DenseRows::new(frame.resolution());
            let made = self.grid_of(primitives, frame, 1, |most, placement| {
                block_lists(&rows, primitives, ListOrder::File, most, placement)
            })?;
            if let Some(root) = made {
                return Ok(root);
            }
            // ends: a grid of one voxel does not multiply anything
            density /= ROOT_COARSENING;
        }
    }

    /// The grid of the voxel `bounds` over these primitives, with the grids below it that are not
    /// left for later. `None` for a grid that would not pay.
    pub(super) fn grid(
        &self,
        ids: &[u32],
        bounds: Aabb<S>,
        depth: u32,
    ) -> Result<Option<Grid<S>>, ExcessCounts> {
        let n = self.resolution(ids.len(), bounds, self.config.density);
        if n == [1; 3] {
            return Ok(None);
        }
        let frame = GridFrame::new(bounds.expanded(self.padding), n);
        self.grid_of(ids.len(), frame, depth, |most, placement| {
            CellLists::build_of(frame.cells(), ids, most, placement)
        })
    }

    /// A grid over so many primitives, whose lists `lists` makes with at most so many references.
    fn grid_of(
        &self,
        primitives: usize,
        frame: GridFrame<S>,
        depth: u32,
        lists: impl FnOnce(u64, &BoxPlacement<'_, S>) -> Result<CellLists, TooManyReferences>,
    ) -> Result<Option<Grid<S>>, ExcessCounts> {
        let cells = frame.cells() as u64;
        self.budget.take([cells, 0])?;
        let allowed = self.config.max_growth * primitives as f64;
        let left = self.budget.references_left();
        let by_division = self.config.historical;
        let placement = BoxPlacement { frame, boxes: &self.boxes, by_division };
        let lists = match lists(left.min(allowed as u64), &placement) {
            Ok(lists) => lists,
            Err(needed) => {
                let refused = self.budget.exceeded_by([0, needed.0]);
                self.budget.give_back([cells, 0]);
                return if needed.0 as f64 > allowed { Ok(None) } else { Err(refused) };
            }
        };
        self.budget.take([0, lists.references() as u64])?;
        let mut children = Vec::new();
        let lists = if depth < self.config.max_depth {
            let mut made = self.children_at_once(&lists, &frame, depth)?.map(Vec::into_iter);
            lists.replaced(|cell, list| {
                if list.len() <= self.config.threshold {
                    return Ok(None);
                }
                let child = match &mut made {
                    Some(made) => made.next().flatten(),
                    None => self.child(&frame, cell, list, depth)?,
                };
                Ok::<_, ExcessCounts>(child.map(|child| {
                    children.push(child);
                    CHILD | (children.len() - 1) as u32
                }))
            })?
        } else {
            lists
        };
        children.shrink_to_fit();
        Ok(Some(Grid { frame, lists: lists.into(), children }))
    }

    /// The children of a grid of this depth that are made with it, on all threads; `None` where
    /// that does not pay.
    fn children_at_once(
        &self,
        lists: &CellLists,
        frame: &GridFrame<S>,
        depth: u32,
    ) -> Result<Option<Vec<Option<Child<S>>>>, ExcessCounts> {
        let pays = depth < self.eager_depth() && should_parallelize(lists.references());
        if !(pays && self.budget.is_in_any_order()) {
            return Ok(None);
        }
        let is_crowded = |&cell: &usize| lists.list(cell).len() > self.config.threshold;
        let crowded: Vec<usize> = (0..frame.cells()).filter(is_crowded).collect();
        let child = |&cell: &usize| self.child(frame, cell, lists.list(cell), depth);
        map(&crowded, &child).into_iter().collect::<Result<_, _>>().map(Some)
    }

    /// Divides a crowded voxel of a grid of this depth, now or later; `None` if it stays as it is.
    fn child(
        &self,
        frame: &GridFrame<S>,
        cell: usize,
        list: &[u32],
        depth: u32,
    ) -> Result<Option<Child<S>>, ExcessCounts> {
        if depth >= self.eager_depth() {
            return Ok(Some(Child::later(list)));
        }
        let Some(grid) = self.grid(list, frame.cell_bounds(cell), depth + 1)? else {
            return Ok(None);
        };
        self.budget.give_back([0, list.len() as u64]);
        Ok(Some(Child::built(grid)))
    }

    /// Voxels per axis for `n` references in `bounds`.
    fn resolution(&self, n: usize, bounds: Aabb<S>, density: f64) -> [u32; 3] {
        let size = bounds.size().to_array();
        let wanted = n as f64 * density;
        let mut voxels = match self.config.rule {
            LevelRule::CubeRoot => [(wanted.cbrt() - 1e-6).ceil().max(1.0) as u32; 3],
            LevelRule::Heterogeneous => heterogeneous(size.map(|s| s.to_f64()), wanted),
            LevelRule::Density => {
                let most = self.budget.cells_left().max(1);
                resolve_by_density(bounds, n, density, most, self.narrowest.to_f64())
            }
        };
        for k in 0..3 {
            let most = (size[k].to_f64() / self.narrowest.to_f64()).clamp(1.0, f64::from(u32::MAX));
            voxels[k] = voxels[k].min(most as u32);
        }
        voxels
    }
}

/// s_i (n / V)^(1/3), axis by axis as Havran and Sixta's (1999) figures show it: every axis is
/// rounded, and the axes after it share the voxels that this leaves. The last one gets n / (n_x
/// n_y); halves are rounded up.
fn heterogeneous(size: [f64; 3], wanted: f64) -> [u32; 3] {
    let [x, y, z] = size;
    // in this order, a NaN (of an axis without length) becomes 1
    let whole = |n: f64| n.round().max(1.0).min(f64::from(MAX_PER_AXIS));
    let nx = whole(x * (wanted / (x * y * z)).cbrt());
    let ny = whole(y * (wanted / nx / (y * z)).sqrt());
    let nz = whole(wanted / nx / ny);
    [nx, ny, nz].map(|n| n as u32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn heterogeneous_rounds_axis_by_axis() {
        assert_eq!(heterogeneous([1.0; 3], 8281.0), [20, 20, 21]);
        // a half is rounded up
        assert_eq!(heterogeneous([1.0; 3], 10.0), [2, 2, 3]);
        // a thin axis has one voxel, and the last axis makes up for it
        assert_eq!(heterogeneous([1.0, 1e-3, 1.0], 100.0), [46, 1, 2]);
        assert_eq!(heterogeneous([1.0, 0.0, 0.0], 100.0), [MAX_PER_AXIS, 1, 1]);
    }
}
