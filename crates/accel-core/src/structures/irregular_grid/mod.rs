//! An irregular grid: a coarse grid whose crowded cells are divided, with boxes of cells grown over
//! neighbours, so that a ray crosses what is empty in one step.
//!
//! Paper: A. Perard-Gayot, J. Kalojanov, P. Slusallek, "GPU Ray Tracing using Irregular Grids",
//! Computer Graphics Forum 36(2), Eurographics 2017.
//!
//! Deviations: cells are divided until lists are short or it no longer pays, by 1 to 8 along each
//! axis, where the paper gives every cell of the top grid one resolution; of cells, only empty ones
//! are merged before they grow, to cubes (`empty_boxes.rs`); equal lists are stored once; a step
//! never goes back along any axis, so that rounding cannot trap a ray; CPU.
//!
//! A step: find the record of a lattice point (`voxels.rs`), test its list, leave its
//! grown box (`course.rs`), go on at the lattice point there. Points are off by a few ulps of the
//! scene, lists have what lies within the padding of the box of their cell, which is more.
//!
//! A batch whose neighbours neither start nor run alike is put in another order first
//! (`query/ray_order.rs`).
//!
//! Built by all threads of the pool in which it is built, to the same bits by any number of them.

mod cells;
mod course;
mod course_lanes;
mod empty_boxes;
mod expand;
mod lattice;
mod overlap;
mod place;
mod shown;
mod subdivide;
mod voxels;

use crate::config;
use crate::geometry::ray::Ray;
use crate::geometry::scalar::Scalar;
use crate::grid::copies::{MOST_REFERENCES_A_COPY, are_copies};
use crate::grid::resolution::resolve_by_density;
use crate::historical::bounds_rule::BoundsRule;
use crate::params::ParamSpec;
use crate::params::{config, specs};
use crate::primitives::{PrimSet, Primitives};
use crate::query::batch;
use crate::query::cells::{CellVisitor, NoCells};
use crate::query::counters::{Counters, NoCounters};
use crate::query::kernel::ListBlocks;
use crate::query::lists::Lists;
use crate::query::mailbox;
use crate::query::side_by_side::LaneDriver;
use crate::query::sink::Sink;
use crate::structure::{
    Batches, BuildError, RayBatch, Structure, StructureInfo, StructureStats, bounds_of,
};
use cells::FIRST_PART;
use course::{LatticeFrame, LatticeRayState};
use lattice::Lattice;
use place::Placement;
use subdivide::{Settings, subdivide};
use voxels::Voxels;

config! {
    /// How the cells are divided and asked.
    pub struct IrregularGridConfig {
        /// quality divides to shorter lists and lets boxes grow over more neighbours
        effort: BuildEffort = ParamSpec::choice("build", "quality", &["fast", "quality"]) => |build| {
            if build == "fast" { FAST } else { QUALITY }
        },
        /// cells of the coarse grid wanted per primitive
        top_density: f64 = ParamSpec::real("top-density", "0.12", 1e-6, 1e3),
        /// cells with no more primitives are not divided; 0: 32 for build=quality, 64 for
        /// build=fast
        longest_list: u64 = ParamSpec::integer("longest-list", "0", 0, 1 << 20),
        /// what a step costs, in tests of a primitive
        step_cost: f64 = ParamSpec::real("step-cost", "3", 0.0, 1e3),
        is_batch: bool = specs::QUERY => |query| query == "batch",
        /// what the divisions in one line of descent may multiply references by, and so most
        /// references to a primitive on average
        max_growth: f64 = ParamSpec::real("max-growth", "64", 1.0, 1e9),
        max_references: u64 = specs::MAX_REFERENCES,
    }
    and mailbox::PARAM, mailbox::SLOTS_PARAM
}

pub static INFO: StructureInfo = StructureInfo {
    paper: "Perard-Gayot, Kalojanov, Slusallek 2017",
    deviations: "recursive division by cost, only empty cells merged, equal lists shared, CPU",
    params: IrregularGridConfig::PARAMS,
    also_tested: &[
        "build=fast",
        "query=batch",
        "top-density=4",
        "top-density=0.001 step-cost=0 longest-list=4",
        "build=fast longest-list=8 step-cost=1",
        "mailbox=hash",
        "mailbox=hash query=batch",
        "build=fast query=batch top-density=0.01 longest-list=5",
    ],
    ..StructureInfo::new(
        "irregular-grid",
        "coarse grid, crowded cells divided, boxes of cells grown over their neighbours",
    )
};

/// Parameters in which the two builds differ.
#[derive(Debug, Clone, Copy)]
struct BuildEffort {
    longest_list: u64,
    /// Parts wanted for each primitive of a cell that is divided.
    density: f64,
    /// Maximum number of neighbours that a face of a box may look at while it moves outward.
    most_neighbours: usize,
}

const FAST: BuildEffort = BuildEffort { longest_list: 64, density: 0.125, most_neighbours: 2 };
const QUALITY: BuildEffort = BuildEffort { longest_list: 32, density: 0.125, most_neighbours: 24 };

pub struct IrregularGrid<S: Scalar> {
    voxels: Voxels,
    lists: Lists<S>,
    place: LatticeFrame<S>,
    /// Rays of a batch are side by side.
    is_batch: bool,
    /// Brings the scene to unit size.
    unit: f64,
    stats: StructureStats,
    /// Position of cells, for `cells`.
    lattice: Lattice,
}

impl<S: Scalar> Structure<S> for IrregularGrid<S> {
    const HAS_AVX512: bool = true;

    type Config = IrregularGridConfig;

    fn build(
        prims: &dyn Primitives<S>,
        config: &config::Settings<IrregularGridConfig>,
    ) -> Result<Self, BuildError> {
        let limits = config.limits();
        let boxes = bounds_of(prims, BoundsRule::Padded, limits.structure)?;
        let effort = config.effort;
        let (scene, smallest) = (boxes.scene(), boxes.smallest_cell());
        let most = u64::from(FIRST_PART) / 8;
        let top = resolve_by_density(scene, prims.len(), config.top_density, most, smallest);
        // copies are in all cells that one of them is in
        let are_copies = are_copies(prims);
        let top = if are_copies { [1; 3] } else { top };
        let most_growth = if are_copies { MOST_REFERENCES_A_COPY as f64 } else { f64::INFINITY };
        let whole = |top| Lattice::new(&scene, top, smallest);
        let mut lattice = whole(top);
        while lattice.top != [1; 3] && !(Placement { lattice: &lattice, boxes: &boxes }).is_sparse()
        {
            lattice = whole(lattice.top.map(|n| n / 2));
        }
        let settings = Settings {
            longest_list: match config.longest_list {
                0 => effort.longest_list,
                given => given,
            } as usize,
            density: effort.density,
            step_cost: config.step_cost,
            limits,
            max_references: config.max_references,
            max_growth: config.max_growth.min(most_growth),
        };
        let mut cells = subdivide(Placement { lattice: &lattice, boxes: &boxes }, settings)?;
        let mut voxels = Voxels::new(&cells, &lattice);
        expand::expand(&mut cells, &voxels, effort.most_neighbours);
        let empty = cells.cells.iter().filter(|cell| cell.list == 0).count();
        let mut stats = StructureStats {
            inner_cells: cells.divided,
            cells: cells.cells.len() as u64,
            empty_cells: empty as u64,
            references: cells.references,
            ..StructureStats::default()
        };
        let lists = cells::lists_of(&mut cells, prims);
        voxels.fill(&cells);
        stats.bytes = (size_of_val(voxels.records.as_slice()) + lists.bytes()) as u64;
        let per_length = lattice.side.map(|side| S::from_f64(1.0 / side));
        Ok(Self {
            voxels,
            lists,
            place: LatticeFrame::new(scene.min, per_length, lattice.resolution()),
            is_batch: config.is_batch,
            unit: scene.magnitude().to_unit_size().to_f64(),
            stats,
            lattice,
        })
    }

    #[inline(always)]
    fn traverse<K: Sink<S>>(&self, ray: &Ray<S>, sink: &mut K) {
        let Some((course, mut at)) = LatticeRayState::of(ray, &self.place) else { return };
        loop {
            let voxel = self.voxels.at(at);
            let list = voxel.list();
            sink.elementary_step(list == 0);
            if list != 0 && self.lists.test(list, sink).is_break()
                || !course.leave(&mut at, &voxel, sink.t_max(), &self.place)
            {
                return;
            }
        }
    }

    #[inline(always)]
    fn batches<P: PrimSet<S>>(&self, _: &P, _: Option<&ListBlocks<S>>) -> Batches {
        if P::HAS_BLOCKS && self.is_batch { Batches::Together } else { Batches::RayByRay }
    }

    #[inline(always)]
    fn answer_batch<P: PrimSet<S>, C: Counters>(
        &self,
        prims: &P,
        _: Option<&ListBlocks<S>>,
        batch: RayBatch<'_, S>,
    ) -> C {
        let unit = Some(self.unit);
        batch::answer::<LaneDriver, NoCounters, _, _, _>(self, prims, batch, unit);
        C::default()
    }

    fn stats(&self) -> StructureStats {
        self.stats
    }

    fn cells(&self, each: &mut CellVisitor<'_>) -> Result<(), NoCells> {
        self.show(each);
        Ok(())
    }
}
