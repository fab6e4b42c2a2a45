//! The recursive grid: voxels that hold many primitives are divided by grids of their own.
//!
//! Paper: D. Jevans, B. Wyvill, "Adaptive Voxel Subdivision for Ray Tracing", Graphics Interface
//! 1989.
//!
//! Deviations: a grid's lists stand in one array, boxes are padded by a few ulps, and plane
//! parameters are recomputed from the true ray on every level. A voxel stays undivided, and the
//! outermost grid is made coarser, where a grid would multiply references too much (copies of one
//! primitive would otherwise be divided for ever). `build=lazy` makes deep grids when a ray first
//! enters their voxel, from any thread; where the paper has no limits, ours leave such a voxel
//! undivided once they are reached. Blocks of triangles (`kernel=block`) are made with the
//! structure, so the lists of grids that are made later stay ids. `boxes=historical` is Havran and
//! Sixta's (1999) grid as their counters show it: boxes enlarged by 0.01 on insertion, and a grid's
//! first voxel that of the point 0.01 beyond its entry.

mod budget;
mod config;
mod levels;

use std::ops::ControlFlow;

use crate::geometry::ray::Ray;
use crate::geometry::scalar::Scalar;
use crate::grid::cell_traversal::{CellPosition, CellTraversal};
use crate::grid::nested_grids::build::room_of;
use crate::grid::voxel_traversal::inverse_direction;
use crate::historical::bounds_rule::BoundsRule;
use crate::parallel::collect;
use crate::params::config::Settings;
use crate::primitives::Primitives;
use crate::query::cells::{CellVisitor, NoCells};
use crate::query::sink::Sink;
use crate::structure::{BuildError, Structure, StructureInfo, StructureStats, bounds_of};
use budget::Budget;
use config::RecursiveGridConfig;
use levels::{Child, Content, Division, Grid, MAX_PRIMITIVES, Voxel};

pub static INFO: StructureInfo = StructureInfo {
    paper: "Jevans, Wyvill 1989",
    deviations: "padded boxes; a voxel stays undivided where its grid would multiply references",
    params: RecursiveGridConfig::PARAMS,
    variants: &["", "build=lazy"],
    also_tested: &[
        "max-depth=2",
        "max-depth=3",
        "resolution=cube-root",
        "kernel=block",
        "kernel=block build=lazy",
        "mailbox=array",
        "build=lazy mailbox=hash",
    ],
    ..StructureInfo::new(
        "recursive-grid",
        "voxels with many primitives are divided by grids of their own, eagerly or on demand",
    )
};

/// Box margin of cones and cylinders in Havran and Sixta's recursive grid, as fitted.
const HISTORICAL_CONE_MARGIN: f64 = 0.001;

/// Their insertion pad, and how far beyond a grid's entry its first voxel is looked up.
const HISTORICAL_PAD: f64 = 0.01;

/// Grids within the voxels of grids.
pub struct RecursiveGrid<S: Scalar> {
    root: Grid<S>,
    division: Division<S>,
    /// How far beyond its entry a grid's first voxel is looked up.
    advance: S,
    /// Traversals start at the ray's origin even if hits only count from `t_min` on, as in 1999.
    from_origin: bool,
}

impl<S: Scalar> Structure<S> for RecursiveGrid<S> {
    const HAS_LISTS: bool = true;

    type Config = RecursiveGridConfig;

    fn build(
        prims: &dyn Primitives<S>,
        settings: &Settings<RecursiveGridConfig>,
    ) -> Result<Self, BuildError> {
        let structure = settings.structure();
        if prims.len() as u64 > MAX_PRIMITIVES {
            return Err(BuildError::TooLarge {
                structure,
                what: "number of primitives",
                needed: prims.len() as u128,
                limit: u128::from(MAX_PRIMITIVES),
            });
        }
        let historical = settings.historical;
        let rule = BoundsRule::of(historical, HISTORICAL_CONE_MARGIN);
        let pad = if historical { S::from_f64(HISTORICAL_PAD) } else { S::ZERO };
        let bounds = bounds_of(prims, rule, structure)?;
        let room = room_of(settings.limits(), settings.max_cells, settings.max_references);
        let mut division = Division {
            boxes: collect(prims.len(), |id| bounds.of(id as u32).expanded(pad)),
            config: RecursiveGridConfig::clone(settings),
            narrowest: Division::narrowest_in(bounds.scene())
                .greater(S::from_f64(bounds.smallest_cell())),
            padding: bounds.padding(),
            budget: Budget::new(room),
        };
        let mut root =
            division.root(bounds.scene(), room).map_err(|needed| room.refused(needed))?;
        if settings.has_joined_lists {
            root.join_lists();
        }
        if !settings.is_lazy {
            division.boxes = Vec::new();
        }
        Ok(Self { root, division, advance: pad, from_origin: historical })
    }

    #[inline(always)]
    fn traverse<K: Sink<S>>(&self, ray: &Ray<S>, sink: &mut K) {
        let t_start = if self.from_origin { S::ZERO } else { ray.t_min };
        let bounds = self.root.frame.bounds();
        if let Some((t, _)) = bounds.clip(ray.origin, ray.direction, t_start, ray.t_max) {
            let _ = self.traverse_grid(&self.root, 1, ray, inverse_direction(ray), t, sink);
        }
    }

    fn lists<'a>(&'a self, each: &mut dyn FnMut(&'a [u32])) {
        self.root.lists(each);
    }

    fn stats(&self) -> StructureStats {
        let mut stats = StructureStats {
            bytes: (size_of::<Self>() + size_of_val(self.division.boxes.as_slice())) as u64,
            pending_cells: self.division.config.is_lazy.then_some(0),
            ..StructureStats::default()
        };
        add_grid(&self.root, &mut stats);
        stats
    }

    fn cells(&self, each: &mut CellVisitor<'_>) -> Result<(), NoCells> {
        self.root.show(0, each);
        Ok(())
    }
}

impl<S: Scalar> RecursiveGrid<S> {
    /// Traverses one grid, which the ray enters at `t_enter`, and the grids within; `Break`
    /// ends the query. A hit before the exit from a voxel ends the traversal of its grid alone: the
    /// grid reaches beyond the one around it, whose next voxel may hold what is closer.
    fn traverse_grid<K: Sink<S>>(
        &self,
        grid: &Grid<S>,
        depth: u32,
        ray: &Ray<S>,
        inverse: [S; 3],
        mut t_enter: S,
        sink: &mut K,
    ) -> ControlFlow<()> {
        sink.inner_step();
        let mut traversal = grid.frame.traversal_at(ray, inverse, t_enter + self.advance);
        loop {
            let t_exit = traversal.t_exit();
            match grid.voxel(traversal.index()) {
                Voxel::Ids(ids) => test(ids, t_exit, sink)?,
                Voxel::Child(child) => {
                    let bounds = || grid.frame.cell_bounds(traversal.index());
                    match child.content(&self.division, bounds, depth + 1) {
                        Content::Grid(inner) => {
                            self.traverse_grid(inner, depth + 1, ray, inverse, t_enter, sink)?
                        }
                        Content::List(ids) => test(ids, t_exit, sink)?,
                    }
                }
            }
            if sink.t_max() < t_exit || !traversal.advance() {
                return ControlFlow::Continue(());
            }
            // a plane beside the ray may be met long before the grid is
            t_enter = t_exit.greater(t_enter);
        }
    }
}

/// A step into an elementary voxel.
#[inline(always)]
fn test<S: Scalar, K: Sink<S>>(ids: &[u32], t_exit: S, sink: &mut K) -> ControlFlow<()> {
    sink.elementary_step(ids.is_empty());
    if ids.is_empty() { ControlFlow::Continue(()) } else { sink.test_in_cell(ids, t_exit) }
}

/// Adds a grid and all within it.
fn add_grid<S: Scalar>(grid: &Grid<S>, stats: &mut StructureStats) {
    stats.inner_cells += 1;
    stats.cells += (grid.frame.cells() - grid.children.len()) as u64;
    stats.empty_cells += grid.lists.empty_cells() as u64;
    stats.references += (grid.lists.references() - grid.children.len()) as u64;
    stats.bytes += (grid.lists.bytes() + size_of_val(grid.children.as_slice())) as u64;
    for child in &grid.children {
        add_child(child, stats);
    }
}

fn add_child<S: Scalar>(child: &Child<S>, stats: &mut StructureStats) {
    let references = match child.built_content() {
        Some(Content::Grid(inner)) => return add_grid(inner, stats),
        Some(Content::List(ids)) => ids.len(),
        None => {
            *stats.pending_cells.get_or_insert(0) += 1;
            child.waiting().len()
        }
    } as u64;
    stats.cells += 1;
    stats.references += references;
    stats.bytes += references * 4;
}
