//! The two-level grid: a coarse grid whose cells are divided by grids of their own resolution.
//!
//! Paper: J. Kalojanov, M. Billeter, P. Slusallek, "Two-Level Grids for Ray Tracing on GPUs",
//! Computer Graphics Forum 30(2) (Eurographics), 2011: two levels are enough for most uneven
//! scenes, and both can be built in parallel by sorting, so that the grid stays among the
//! structures that are built fastest.
//!
//! Deviations: references are sorted into upper cells by the counting sort of `block_lists.rs`,
//! and within each upper cell by another, instead of all pairs of a level by radix; resolutions
//! follow from the number of references by the rule *density* of `resolution.rs`, not from their
//! cost model; a leaf grid that would list most primitives in most of its cells is made coarser, so
//! that copies of a large primitive do not multiply; upper cells without primitives have no leaf
//! cell. An upper cell is 8 bytes: its leaf grid is computed by each ray that comes by. Rays are
//! traversed one by one.

mod leaf_cells;

use std::ops::ControlFlow;

use crate::config;
use crate::geometry::ray::Ray;
use crate::geometry::scalar::Scalar;
use crate::grid::cell_lists::CellLists;
use crate::grid::cell_traversal::{CellPosition, CellTraversal};
use crate::grid::nested_grids::build::room_of;
use crate::grid::regular_grid::{CellStorage, Contents, GridConfig, contents_of, stored};
use crate::grid::voxel_traversal::{CellDivision, GridFrame, VoxelTraversal, inverse_direction};
use crate::params::ParamSpec;
use crate::params::config::Settings;
use crate::params::specs;
use crate::primitives::Primitives;
use crate::query::cells::{Cell, CellVisitor, NoCells};
use crate::query::kernel;
use crate::query::mailbox;
use crate::query::sink::Sink;
use crate::structure::{BuildError, Structure, StructureInfo, StructureStats};
use crate::update::{Change, INCREMENTAL, is_worth_changing};
use leaf_cells::{LeafCells, UpperCell, UpperCells};

pub static INFO: StructureInfo = StructureInfo {
    paper: "Kalojanov, Billeter, Slusallek 2011",
    deviations: "counting sorts, not radix; leaf grids of no use are made coarser",
    params: &[
        specs::RESOLUTION,
        ParamSpec {
            summary: "upper cells per primitive, for the rules that have it",
            default: "0.12",
            ..specs::DENSITY
        },
        LeafConfig::PARAMS[0],
        specs::max_cells(specs::MAX_CELLS.default, (1 << 32) - 2),
        specs::MAX_REFERENCES,
        kernel::PARAM,
        INCREMENTAL,
        mailbox::PARAM,
        mailbox::SLOTS_PARAM,
    ],
    also_tested: &[
        "kernel=block",
        "density=0.01 leaf-density=20",
        "density=2 leaf-density=0.5",
        "mailbox=hash",
    ],
    ..StructureInfo::new(
        "two-level-grid",
        "a coarse grid whose cells hold grids, each of a resolution of its own",
    )
};

config! {
    /// The grids within the upper one.
    pub struct LeafConfig {
        /// leaf cells per primitive of an upper cell
        leaf_density: f64 = ParamSpec::real("leaf-density", "2.4", 1e-6, 1e6),
    }
}

/// The upper grid and those within.
type TwoLevelConfig = GridConfig<LeafConfig>;

/// Two levels of grids.
pub struct TwoLevelGrid<S: Scalar> {
    upper: GridFrame<S>,
    division: CellDivision<S>,
    cells: Vec<UpperCell>,
    leaves: LeafCells,
    /// With `update=incremental`: what the upper cells list.
    lists: Option<CellLists>,
}

/// The upper cells of these contents, with their lists.
fn upper_cells<'a, 'p, S: Scalar>(
    settings: &Settings<TwoLevelConfig>,
    contents: &'a Contents<'p, S>,
    division: &'a CellDivision<S>,
    lists: &'a CellLists,
) -> UpperCells<'a, 'p, S> {
    let room = room_of(settings.limits(), settings.max_cells, settings.max_references);
    UpperCells { contents, division, lists, density: settings.own.leaf_density, room }
}

impl<S: Scalar> TwoLevelGrid<S> {
    /// Changes the cells that something moved in; false where the upper grid is another one, and
    /// nothing was done.
    fn change(
        &mut self,
        prims: &dyn Primitives<S>,
        settings: &Settings<TwoLevelConfig>,
        moved: &[u32],
    ) -> Result<bool, BuildError> {
        let Some(lists) = &mut self.lists else { return Ok(false) };
        let contents = contents_of(prims, settings.limits(), settings)?;
        if contents.frame != self.upper {
            return Ok(false);
        }
        let Some(changed) = CellStorage::change(lists, &contents, moved) else { return Ok(false) };
        let upper = upper_cells(settings, &contents, &self.division, lists);
        let before = (self.cells.as_slice(), &self.leaves);
        (self.cells, self.leaves) = upper.redivide(before, &changed.changed)?;
        Ok(true)
    }
}

impl<S: Scalar> Structure<S> for TwoLevelGrid<S> {
    const HAS_LISTS: bool = true;

    type Config = TwoLevelConfig;

    fn build(
        prims: &dyn Primitives<S>,
        settings: &Settings<TwoLevelConfig>,
    ) -> Result<Self, BuildError> {
        let (contents, lists) = stored::<S, CellLists, _>(prims, settings.limits(), settings, &())?;
        let division = CellDivision::new(&contents.frame, contents.padding());
        let (cells, leaves) = upper_cells(settings, &contents, &division, &lists).divide()?;
        let lists = settings.is_incremental.then_some(lists);
        Ok(Self { upper: contents.frame, division, cells, leaves, lists })
    }

    fn update(
        &mut self,
        prims: &dyn Primitives<S>,
        settings: &Settings<TwoLevelConfig>,
        moved: &[u32],
    ) -> Result<Change, BuildError> {
        if settings.is_incremental
            && is_worth_changing(moved.len(), prims.len())
            && self.change(prims, settings, moved)?
        {
            return Ok(Change::Updated);
        }
        *self = Self::build(prims, settings)?;
        Ok(Change::Rebuilt)
    }

    #[inline(always)]
    fn traverse<K: Sink<S>>(&self, ray: &Ray<S>, sink: &mut K) {
        sink.inner_step();
        let bounds = self.upper.bounds();
        let Some((mut t, _)) = bounds.clip(ray.origin, ray.direction, ray.t_min, ray.t_max) else {
            return;
        };
        let inverse = inverse_direction(ray);
        let mut traversal = self.upper.traversal_at(ray, inverse, t);
        loop {
            let Some(cell) = self.cells.get(traversal.index()) else { return };
            if cell.is_divided() {
                sink.inner_step();
                let leaf = self.division.grid(traversal.coords(), cell.resolution());
                if self.leaves.traverse(cell, leaf.traversal_at(ray, inverse, t), sink).is_break() {
                    return;
                }
            } else {
                let list = self.leaves.only_list(cell);
                sink.elementary_step(list.is_empty());
                if !list.is_empty() && sink.test(list).is_break() {
                    return;
                }
            }
            let t_exit = traversal.t_exit();
            if sink.t_max() < t_exit || !traversal.advance() {
                return;
            }
            // a plane beside the ray may be met long before the grid is
            t = t_exit.greater(t);
        }
    }

    /// N_IN is 1 for the upper grid and 1 for every cell of it that is divided.
    fn lists<'a>(&'a self, each: &mut dyn FnMut(&'a [u32])) {
        self.leaves.lists().lists().for_each(each);
    }

    fn stats(&self) -> StructureStats {
        let divided = self.cells.iter().filter(|cell| cell.is_divided()).count() as u64;
        let vacant = self.cells.iter().filter(|cell| cell.is_vacant()).count() as u64;
        let lists = self.leaves.lists().stats();
        let upper = self.lists.as_ref().map_or(0, CellLists::bytes);
        StructureStats {
            inner_cells: 1 + divided,
            cells: lists.cells + vacant,
            empty_cells: lists.empty_cells + vacant,
            bytes: (size_of_val(self.cells.as_slice()) + upper) as u64 + lists.bytes,
            ..lists
        }
    }

    fn cells(&self, each: &mut CellVisitor<'_>) -> Result<(), NoCells> {
        each(Cell::inner(self.upper.bounds(), 0));
        for (index, cell) in self.cells.iter().enumerate() {
            if !cell.is_divided() {
                let list = self.leaves.only_list(cell);
                each(Cell::elementary(self.upper.cell_bounds(index), 1, list));
                continue;
            }
            let inner = self.division.grid(self.upper.coords(index), cell.resolution());
            each(Cell::inner(inner.bounds(), 1));
            for leaf in 0..inner.cells() {
                each(Cell::elementary(inner.cell_bounds(leaf), 2, self.leaves.list(cell, leaf)));
            }
        }
        Ok(())
    }
}

impl LeafCells {
    /// Visits the leaf cells of an upper cell until the traversal leaves it or nothing closer can
    /// follow there; `Break` ends the query.
    #[inline(always)]
    fn traverse<S: Scalar, K: Sink<S>>(
        &self,
        cell: &UpperCell,
        mut traversal: VoxelTraversal<S>,
        sink: &mut K,
    ) -> ControlFlow<()> {
        loop {
            let list = self.list(cell, traversal.index());
            sink.elementary_step(list.is_empty());
            if !list.is_empty() {
                sink.test(list)?;
            }
            if sink.t_max() < traversal.t_exit() || !traversal.advance() {
                return ControlFlow::Continue(());
            }
        }
    }
}
