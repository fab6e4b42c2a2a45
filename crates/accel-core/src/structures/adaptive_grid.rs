//! Adaptive grids: clusters by wasted surface, a hierarchy of boxes over them, a grid in each, and
//! sub-voxel grids in crowded voxels.
//!
//! Paper: K. Klimaszewski, T. Sederberg, "Faster Ray Tracing Using Adaptive Grids", IEEE CG&A
//! 17(1), 1997. Clusters: see `clustering/agglomerate.rs`. Every cluster gets a grid over its box;
//! primitives that joined no cluster are *orphans*. A voxel with several primitives gets a grid
//! over the part of it that they fill.
//!
//! Deviations: the hierarchy is a binary one made by a sweep (`cluster_bvh.rs`); clusters of many
//! primitives are found locally; sub-voxel grids nest as deep as `levels` says and are left out
//! where most primitives would be in most cells anyway; with `orphan-grid=on` orphans share a
//! grid, else each is a leaf of the hierarchy. `boxes=historical` is Havran and Sixta's (1999) as
//! far as their counters tell: one level of sub-voxel grids, each over the whole boxes of its
//! primitives, resolutions rounded as `HISTORICAL_ROUNDING` says, and an axis thinner than 0.01
//! becomes 0.01.

use std::collections::HashSet;

use crate::config;
use crate::geometry::aabb::Aabb;
use crate::geometry::ray::Ray;
use crate::geometry::scalar::{Scalar, Vector};
use crate::grid::nested_grids::NestedGrids;
use crate::grid::nested_grids::build::{BuildRules, LooseGrids, room_of};
use crate::grid::voxel_traversal::GridFrame;
use crate::params::ParamSpec;
use crate::params::config::Settings;
use crate::params::specs;
use crate::primitives::Primitives;
use crate::query::cells::{Cell, CellVisitor, NoCells};
use crate::query::kernel;
use crate::query::mailbox::{self, NoMailbox};
use crate::query::sink::Sink;
use crate::structure::{BuildError, Structure, StructureInfo, StructureStats};
use crate::structures::hug::{Boxes, boxes_of, historical_frame, useful_frame};
use crate::tree::cluster_bvh::{ClusterBvh, Item};
use crate::tree::clustering::agglomerate::{MergeRule, agglomerate, surface};

config! {
    /// How adaptive grids are built.
    pub struct AdaptiveGridConfig {
        /// clusters merge while surface / (sum of both surfaces) is below it
        f: f64 = ParamSpec::real("f", "1.5", 0.0, 1e6),
        /// largest surface of a cluster, as a fraction of the scene's
        m: f64 = ParamSpec::real("m", "0.5", 0.0, 1e6),
        /// primitives without cluster share a grid, o=+; else they are leaves, o=-
        has_orphan_grid: bool = ParamSpec::choice("orphan-grid", "off", &["on", "off"]) => |grid| grid == "on",
        /// voxels per primitive of a grid
        density: f64 = ParamSpec { default: "1", ..specs::DENSITY },
        /// a voxel with this many primitives is divided again
        split: usize = ParamSpec::integer("split", "4", 2, 1 << 32),
        /// levels of sub-voxel grids
        levels: u64 = ParamSpec::integer("levels", "3", 0, 8),
        /// up to this many clusters the best of all pairs is merged, beyond it locally
        exact_clusters: usize = ParamSpec::integer("exact-clusters", "256", 2, 1 << 16),
        historical: bool = specs::BOXES => specs::is_historical,
        max_cells: u64 = specs::max_cells("134217728", (1 << 32) - 2),
        max_references: u64 = specs::MAX_REFERENCES,
    }
    and kernel::PARAM, mailbox::PARAM, mailbox::SLOTS_PARAM
}

pub static INFO: StructureInfo = StructureInfo {
    paper: "Klimaszewski, Sederberg 1997",
    deviations: "binary hierarchy; large scenes clustered locally; useless sub-voxel grids left out",
    params: AdaptiveGridConfig::PARAMS,
    also_tested: &[
        "kernel=block",
        "exact-clusters=4096",
        "m=0.1",
        "orphan-grid=on m=0.1",
        "mailbox=hash",
    ],
    ..StructureInfo::new(
        "adaptive-grid",
        "grids over clusters, crowded voxels divided again, a hierarchy of boxes over all",
    )
};

/// s_i (n / volume)^(1/3) plus this, truncated, is the historical resolution of a cluster's grid
/// and of a sub-voxel grid: fitted to the published counters of all scenes together.
const HISTORICAL_ROUNDING: [f64; 2] = [0.5, 0.4];

/// Smaller clusters got no grid in 1999: their members were orphans.
const HISTORICAL_CLUSTER: usize = 8;

/// Clusters under a hierarchy of boxes.
pub struct AdaptiveGrid<S: Scalar> {
    tree: ClusterBvh<S>,
    grids: NestedGrids<S>,
    orphans: u64,
    /// Traversals start at the ray's origin even if hits only count from `t_min` on, as in 1999.
    from_origin: bool,
}

/// Primitives that shall have a grid of their own.
struct PendingGrid<S: Scalar> {
    ids: Vec<u32>,
    bounds: Aabb<S>,
    /// 0 for the grid of a cluster.
    level: u64,
    /// Its cells, where they are known already.
    frame: Option<GridFrame<S>>,
}

/// Builds all grids of the hierarchy; shared by them.
struct GridBuilder<'a, S: Scalar> {
    boxes: &'a [Aabb<S>],
    padding: S,
    config: &'a AdaptiveGridConfig,
    rules: BuildRules,
}

impl<S: Scalar> Structure<S> for AdaptiveGrid<S> {
    const HAS_LISTS: bool = true;

    type Config = AdaptiveGridConfig;

    fn build(
        prims: &dyn Primitives<S>,
        settings: &Settings<AdaptiveGridConfig>,
    ) -> Result<Self, BuildError> {
        let historical = settings.historical;
        let Boxes { of: boxes, scene, padding } =
            boxes_of(prims, historical, settings.structure())?;
        let rule = MergeRule {
            ratio: settings.f,
            max_surface: settings.m * surface(&scene),
            exact_up_to: settings.exact_clusters,
        };
        let fewest = if historical { HISTORICAL_CLUSTER } else { 2 };
        let (clusters, orphans): (Vec<_>, Vec<_>) =
            agglomerate(&boxes, &rule).into_iter().partition(|c| c.len() >= fewest);
        let orphans = orphans.concat();
        let room = room_of(settings.limits(), settings.max_cells, settings.max_references);
        let rules = BuildRules { historical, room };
        let maker = GridBuilder { boxes: &boxes, padding, config: settings, rules };
        let orphan_count = orphans.len() as u64;
        let mut items = Vec::new();
        let mut crowds = clusters;
        if settings.has_orphan_grid && !orphans.is_empty() {
            crowds.push(orphans);
        } else {
            items.extend(orphans.iter().map(|&id| (Item::Orphan(id), boxes[id as usize])));
        }
        let crowds: Vec<_> = crowds.into_iter().map(|ids| maker.crowd(ids)).collect();
        items.extend(crowds.iter().zip(0..).map(|(c, grid)| (Item::Grid(grid), c.bounds)));
        let grids = maker.make(crowds)?;
        Ok(Self {
            tree: ClusterBvh::new(items),
            grids,
            orphans: orphan_count,
            from_origin: historical,
        })
    }

    #[inline(always)]
    fn traverse<K: Sink<S>>(&self, ray: &Ray<S>, sink: &mut K) {
        self.traverse_with(ray, sink, || {});
    }

    /// An orphan that is a leaf of the hierarchy stands in no list and is tested alone.
    fn lists<'a>(&'a self, each: &mut dyn FnMut(&'a [u32])) {
        self.grids.lists().for_each(each);
    }

    /// N_IN is the number of the hierarchy's inner nodes and of all grids; N_V of all cells that
    /// are not divided again; an orphan that is a leaf is one cell with one reference. With
    /// `boxes=historical` such an orphan counts as two references, and a node once more: in N_V
    /// if an orphan is right below it, else in N_IN.
    fn stats(&self) -> StructureStats {
        let census = self.grids.census();
        let mut lone = 0;
        self.tree.visit(&mut |_, _, item| lone += u64::from(matches!(item, Some(Item::Orphan(_)))));
        let (mut inner, mut cells, mut references) = (self.tree.inner_nodes(), lone, lone);
        if self.from_origin {
            cells = self.tree.inner_nodes_with_orphans();
            inner += inner - cells;
            references += lone;
        }
        StructureStats {
            inner_cells: inner + self.grids.len() as u64,
            cells: census.cells + cells,
            empty_cells: census.empty_cells,
            references: census.references + references,
            resolution: None,
            bytes: self.grids.bytes() + self.tree.bytes(),
            ..StructureStats::default()
        }
    }

    fn cells(&self, each: &mut CellVisitor<'_>) -> Result<(), NoCells> {
        let mut seen = HashSet::new();
        self.tree.visit(&mut |bounds, depth, item| match item {
            None => each(Cell::inner(bounds, depth)),
            Some(Item::Orphan(id)) => each(Cell::elementary(bounds, depth, &[id])),
            Some(Item::Grid(grid)) => {
                each(Cell::inner(self.grids.bounds(grid), depth));
                self.grids.show(grid, depth + 1, true, &mut seen, each);
            }
        });
        Ok(())
    }
}

impl<S: Scalar> AdaptiveGrid<S> {
    /// [`Structure::traverse`] that also reports every inner node of the hierarchy entered: N_BIT
    /// of 1999, where a node that holds one grid and one orphan was one test.
    #[inline(always)]
    pub fn traverse_with<K: Sink<S>>(&self, ray: &Ray<S>, sink: &mut K, on_node: impl FnMut()) {
        let t_start = if self.from_origin { S::ZERO } else { ray.t_min };
        self.tree.traverse(ray, t_start, sink, on_node, |item, sink| match item {
            Item::Grid(grid) => {
                sink.inner_step();
                self.grids.traverse(grid, ray, t_start, sink, &mut NoMailbox)
            }
            Item::Orphan(id) => {
                sink.elementary_step(false);
                sink.test(&[id])
            }
        });
    }

    /// N_ORP: primitives without cluster.
    pub fn orphans(&self) -> u64 {
        self.orphans
    }

    /// Inner nodes of the hierarchy.
    pub fn hierarchy_nodes(&self) -> u64 {
        self.tree.inner_nodes()
    }
}

impl<S: Scalar> GridBuilder<'_, S> {
    fn crowd(&self, ids: Vec<u32>) -> PendingGrid<S> {
        let boxes = ids.iter().map(|&i| self.boxes[i as usize]);
        let bounds = boxes.fold(Aabb::empty(), Aabb::union).expanded(self.padding);
        PendingGrid { ids, bounds, level: 0, frame: None }
    }

    /// Makes the grids of all clusters, then those within their voxels, level by level.
    fn make(&self, crowds: Vec<PendingGrid<S>>) -> Result<NestedGrids<S>, BuildError> {
        let mut grids = NestedGrids::new();
        let mut level = crowds;
        while !level.is_empty() {
            let (first, mut below) = (grids.len() + level.len(), Vec::new());
            let push = |grids: &mut _, crowd: &_| self.push(grids, crowd);
            grids.push_all(&level, &self.rules, push, &mut |inner| {
                below.push(inner);
                (first + below.len() - 1) as u32
            })?;
            level = below;
        }
        Ok(grids)
    }

    /// Adds the grid of a crowd, with the crowds in its voxels.
    fn push(
        &self,
        grids: &mut LooseGrids<S, PendingGrid<S>>,
        crowd: &PendingGrid<S>,
    ) -> Result<(), BuildError> {
        let boxes: Vec<_> = crowd.ids.iter().map(|&i| self.boxes[i as usize]).collect();
        let frame = self.frame(crowd, &boxes)?;
        // a grid of one cell has not helped, another one below it would not either
        let may_divide = crowd.level < self.config.levels && frame.cells() > 1;
        grids.push_divided(frame, (&crowd.ids, &boxes), &self.rules, |cell, list| {
            if !may_divide || list.len() < self.config.split {
                return None;
            }
            self.crowd_in(cell, list.iter().map(|&i| crowd.ids[i as usize]), crowd.level + 1)
        })
    }

    /// The crowd in a voxel; `None` if a grid of one cell is all that would come of it, which is
    /// asked of today's grids only.
    fn crowd_in(
        &self,
        cell: Aabb<S>,
        ids: impl Iterator<Item = u32> + Clone,
        level: u64,
    ) -> Option<PendingGrid<S>> {
        let boxes = ids.clone().map(|i| self.boxes[i as usize]);
        let bounds = self.within(boxes.clone(), cell);
        let frame = (!self.config.historical).then(|| self.useful_frame(bounds, boxes));
        let is_hopeless = frame.is_some_and(|frame| frame.cells() == 1);
        (!is_hopeless).then(|| PendingGrid { ids: ids.collect(), bounds, level, frame })
    }

    fn frame(&self, crowd: &PendingGrid<S>, boxes: &[Aabb<S>]) -> Result<GridFrame<S>, BuildError> {
        if self.config.historical {
            let wanted = HISTORICAL_ROUNDING[usize::from(crowd.level > 0)];
            return historical_frame(crowd.bounds, boxes.len(), wanted, &self.rules.room);
        }
        Ok(crowd.frame.unwrap_or_else(|| self.useful_frame(crowd.bounds, boxes.iter().copied())))
    }

    fn useful_frame(
        &self,
        bounds: Aabb<S>,
        boxes: impl Iterator<Item = Aabb<S>> + Clone,
    ) -> GridFrame<S> {
        useful_frame(bounds, boxes, self.config.density, self.padding, &self.rules.room)
    }

    /// The part of a voxel that its primitives fill; in 1999, all that they fill.
    fn within(&self, boxes: impl Iterator<Item = Aabb<S>>, cell: Aabb<S>) -> Aabb<S> {
        let all = boxes.fold(Aabb::empty(), Aabb::union);
        if self.config.historical {
            return all;
        }
        // a box that only touches the voxel may lie outside by rounding
        let (lo, hi) = (all.min.max(cell.min), all.max.min(cell.max));
        Aabb { min: lo.min(hi), max: lo.max(hi) }.expanded(self.padding)
    }
}
