//! HUG: a hierarchy of uniform grids over clusters of primitives of like size.
//!
//! Paper: F. Cazals, G. Drettakis, C. Puech, "Filtering, Clustering and Hierarchy Construction: a
//! New Solution for Ray-Tracing Complex Scenes", Computer Graphics Forum 14(3) (Eurographics),
//! 1995. Filtering: primitives fall into classes of equal width in the logarithm of their size
//! (longest side of the box). Clustering: within a class, connected components of boxes nearer
//! than a gap. Every cluster gets a grid, which is inserted like a primitive into the smallest
//! grid of a larger class that holds it; a ray traverses a grid only once, however many cells list
//! it.
//!
//! Deviations: the largest class is not clustered but fills the root grid over the scene; clusters
//! of fewer than `min-objects` primitives go to the grid around them; a grid whose primitives
//! would cover most of its cells is made coarser; the mailbox is a small table on the stack that
//! may forget. `boxes=historical` is Havran and Sixta's (1999) HUG as far as their counters tell
//! (see [`HISTORY`]).

use std::collections::HashSet;

use crate::capacity::CapacityLimits;
use crate::config;
use crate::geometry::aabb::Aabb;
use crate::geometry::ray::Ray;
use crate::geometry::scalar::{Scalar, Vec3, Vector};
use crate::grid::nested_grids::build::{BuildRules, LooseGrids, references_in, room_of};
use crate::grid::nested_grids::{NestedGrids, VisitedGrids};
use crate::grid::resolution::{MAX_PER_AXIS, resolve_by_density};
use crate::grid::voxel_traversal::GridFrame;
use crate::historical::bounds_rule::{BoundsRule, smallest_cell};
use crate::parallel::collect;
use crate::params::ParamSpec;
use crate::params::config::Settings;
use crate::params::specs;
use crate::primitives::{PrimitiveKind, Primitives};
use crate::query::cells::{Cell, CellVisitor, NoCells};
use crate::query::kernel;
use crate::query::mailbox::{self, Mailbox as _};
use crate::query::sink::Sink;
use crate::structure::{BuildError, Structure, StructureInfo, StructureStats, bounds_of};
use crate::tree::clustering::box_tree::{BoxTree, NeighbourRule};
use crate::tree::clustering::components::components;

config! {
    /// How a HUG is built.
    pub struct HugConfig {
        /// classes of equal width in log(size), HNG
        size_classes: usize = ParamSpec::integer("size-classes", "3", 1, 16),
        /// largest distance of neighbours on every axis, in world units, HCN
        gap: f64 = ParamSpec::real("gap", "0", -1e30, 1e30),
        /// smaller clusters get no grid
        min_objects: usize = ParamSpec::integer("min-objects", "8", 1, 1 << 30),
        /// voxels per primitive of a grid
        density: f64 = specs::DENSITY,
        historical: bool = specs::BOXES => specs::is_historical,
        /// with boxes=historical, primitives that the root grid is sized for; 0: those of the
        /// largest class
        root_objects: usize = ParamSpec::integer("root-objects", "0", 0, 1 << 30),
        max_cells: u64 = specs::max_cells("134217728", (1 << 32) - 2),
        max_references: u64 = specs::MAX_REFERENCES,
    }
    and kernel::BLOCK_PARAM, mailbox::PARAM, mailbox::SLOTS_PARAM
}

pub static INFO: StructureInfo = StructureInfo {
    paper: "Cazals, Drettakis, Puech 1995",
    deviations: "largest class unclustered in the root; small clusters dissolve; coarser where useless",
    params: HugConfig::PARAMS,
    also_tested: &["kernel=scalar", "size-classes=2", "size-classes=4", "mailbox=primitive"],
    ..StructureInfo::new(
        "hug",
        "grids over clusters of primitives of like size, nested, each traversed once per ray",
    )
};

/// The rules of `boxes=historical`, fitted to published counters (Havran and Sixta 1999).
pub const HISTORY: &str = "an axis thinner than 0.01 becomes 0.01; neighbours overlap by more than \
    a touch; s_i (n / volume)^(1/3) voxels an axis, rounded up, with n the primitives of the \
    grid's own class; primitives but spheres inserted with boxes 0.01 larger on every side, the root's \
    box 0.001 larger; a ray that misses the root's box takes no step";

/// Thinnest box of the historical setting.
const HISTORICAL_THICKNESS: f64 = 0.01;

/// Added on insertion to every side of the box of what is no sphere in the historical setting.
const HISTORICAL_MARGIN: f64 = 0.01;

/// Added to every side of the historical root's box.
const HISTORICAL_ROOT_MARGIN: f64 = 0.001;

/// Rounds up all but what is a whole number already.
const HISTORICAL_ROUNDING: f64 = 1.0 - 1e-6;

/// A grid that would list its primitives more often than this on average is made coarser.
const REFERENCES_PER_PRIMITIVE: u64 = 32;

/// A hierarchy of uniform grids; number 0 is the root.
pub struct Hug<S: Scalar> {
    grids: NestedGrids<S>,
    /// Traversals start at the ray's origin even if hits only count from `t_min` on, as in 1999.
    from_origin: bool,
}

/// A grid before it is filled.
struct PlannedGrid<S: Scalar> {
    bounds: Aabb<S>,
    class: usize,
    /// Primitives of the cluster it was made for.
    own: usize,
    /// All primitives that go to it, ascending.
    ids: Vec<u32>,
    /// The grids that go to it.
    inner: Vec<u32>,
}

impl<S: Scalar> Structure<S> for Hug<S> {
    const HAS_LISTS: bool = true;

    type Config = HugConfig;

    fn build(
        prims: &dyn Primitives<S>,
        settings: &Settings<HugConfig>,
    ) -> Result<Self, BuildError> {
        let historical = settings.historical;
        let Boxes { of: boxes, scene, padding } =
            boxes_of(prims, historical, settings.structure())?;
        let mut plans = plan(&boxes, scene, padding, settings);
        if let (true, Some(root)) = (historical, plans.first_mut()) {
            root.bounds = root.bounds.expanded(S::from_f64(HISTORICAL_ROOT_MARGIN));
            let asked = settings.root_objects;
            root.own = if asked == 0 { root.own } else { asked };
        }
        let boxes = if historical { inserted(prims) } else { boxes };
        let grids = fill(&boxes, &plans, padding, settings)?;
        Ok(Self { grids, from_origin: historical })
    }

    #[inline(always)]
    fn traverse<K: Sink<S>>(&self, ray: &Ray<S>, sink: &mut K) {
        let t_start = if self.from_origin { S::ZERO } else { ray.t_min };
        if !self.from_origin || self.grids.meets(0, ray, t_start) {
            sink.inner_step();
        }
        let mut visited = VisitedGrids::new();
        visited.is_new(0);
        let _ = self.grids.traverse(0, ray, t_start, sink, &mut visited);
    }

    /// N_IN is 1 for the root and 1 for every cell that holds a grid; N_V all other cells.
    fn lists<'a>(&'a self, each: &mut dyn FnMut(&'a [u32])) {
        self.grids.lists().for_each(each);
    }

    fn stats(&self) -> StructureStats {
        let census = self.grids.census();
        StructureStats {
            inner_cells: 1 + census.dividing_cells,
            cells: census.cells,
            empty_cells: census.empty_cells,
            references: census.references,
            resolution: None,
            bytes: self.grids.bytes(),
            ..StructureStats::default()
        }
    }

    fn cells(&self, each: &mut CellVisitor<'_>) -> Result<(), NoCells> {
        each(Cell::inner(self.grids.bounds(0), 0));
        self.grids.show(0, 1, false, &mut HashSet::new(), each);
        Ok(())
    }
}

/// Input of a build.
pub(super) struct Boxes<S: Scalar> {
    pub of: Vec<Aabb<S>>,
    pub scene: Aabb<S>,
    /// By how much the boxes of grids grow.
    pub padding: S,
}

pub(super) fn boxes_of<S: Scalar>(
    prims: &dyn Primitives<S>,
    historical: bool,
    structure: &'static str,
) -> Result<Boxes<S>, BuildError> {
    let padded = bounds_of(prims, BoundsRule::Padded, structure)?;
    if !historical {
        let of = padded.all();
        return Ok(Boxes { of, scene: padded.scene(), padding: padded.padding() });
    }
    let of = collect(prims.len(), |id| at_least(prims.bounds(id as u32)));
    let scene = of.iter().fold(Aabb::empty(), |all, b| all.union(*b));
    Ok(Boxes { of, scene, padding: S::ZERO })
}

/// The box with no side below the historical thickness.
fn at_least<S: Scalar>(b: Aabb<S>) -> Aabb<S> {
    let (mut lo, mut hi) = (b.min.to_array(), b.max.to_array());
    let half = S::from_f64(0.5 * HISTORICAL_THICKNESS);
    for k in 0..3 {
        if hi[k] - lo[k] < half + half {
            let middle = (lo[k] + hi[k]) * S::from_f64(0.5);
            (lo[k], hi[k]) = (middle - half, middle + half);
        }
    }
    Aabb { min: Vec3::<S>::from_array(lo), max: Vec3::<S>::from_array(hi) }
}

/// The boxes as they were inserted in 1999: those of spheres exact, all others larger.
fn inserted<S: Scalar>(prims: &dyn Primitives<S>) -> Vec<Aabb<S>> {
    let margin = S::from_f64(HISTORICAL_MARGIN);
    let of = |id| match prims.kind(id) {
        PrimitiveKind::Sphere => prims.bounds(id),
        _ => prims.bounds(id).expanded(margin),
    };
    (0..prims.len() as u32).map(of).collect()
}

/// Class of every box, 0 for the smallest: equal bins in the logarithm of the longest side.
fn classes<S: Scalar>(boxes: &[Aabb<S>], count: usize) -> Vec<usize> {
    let size = |b: &Aabb<S>| {
        let longest = b.size().to_array().into_iter().fold(0.0, |m, s| s.to_f64().max(m));
        longest.clamp(f64::MIN_POSITIVE, f64::MAX).ln()
    };
    let sizes: Vec<f64> = boxes.iter().map(size).collect();
    let least = sizes.iter().copied().fold(f64::INFINITY, f64::min);
    let most = sizes.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    if most <= least {
        return vec![count - 1; boxes.len()];
    }
    let class = |s: f64| ((s - least) / (most - least) * count as f64) as usize;
    sizes.into_iter().map(|s| class(s).min(count - 1)).collect()
}

/// Filtering, clustering and hierarchy: which grids there are, and what goes to each.
fn plan<S: Scalar>(
    boxes: &[Aabb<S>],
    scene: Aabb<S>,
    padding: S,
    config: &HugConfig,
) -> Vec<PlannedGrid<S>> {
    let count = config.size_classes;
    let near = NeighbourRule { gap: S::from_f64(config.gap), closed: !config.historical };
    let class_of = classes(boxes, count);
    let of_class = |class: usize| -> Vec<u32> {
        (0..boxes.len() as u32).filter(|&i| class_of[i as usize] == class).collect()
    };
    let planned = |bounds, class, ids: Vec<u32>| PlannedGrid {
        bounds,
        class,
        own: ids.len(),
        ids,
        inner: Vec::new(),
    };
    let mut plans = vec![planned(scene, count - 1, of_class(count - 1))];
    // clusters without a grid, with their boxes and classes
    let mut loose: Vec<(Vec<u32>, Aabb<S>, usize)> = Vec::new();
    for class in (0..count.saturating_sub(1)).rev() {
        let ids = of_class(class);
        let class_boxes: Vec<_> = ids.iter().map(|&i| boxes[i as usize]).collect();
        for members in components(&class_boxes, &near) {
            let members: Vec<u32> = members.into_iter().map(|i| ids[i as usize]).collect();
            let bounds = members.iter().fold(Aabb::empty(), |b, &i| b.union(boxes[i as usize]));
            if members.len() < config.min_objects {
                loose.push((members, bounds, class));
            } else {
                plans.push(planned(bounds.expanded(padding), class, members));
            }
        }
    }
    let bounds: Vec<_> = plans.iter().map(|p| p.bounds).collect();
    let tree = BoxTree::new(&bounds);
    for (members, bounds, class) in loose {
        let owner = smallest_around(&tree, &plans, &bounds, class);
        plans[owner].ids.extend(members);
    }
    for number in 1..plans.len() {
        let parent = smallest_around(&tree, &plans, &bounds[number], plans[number].class);
        plans[parent].inner.push(number as u32);
    }
    plans.iter_mut().for_each(|plan| plan.ids.sort_unstable());
    plans
}

/// The smallest grid of a class above `class` that holds the box; the root if there is none.
fn smallest_around<S: Scalar>(
    tree: &BoxTree<S>,
    plans: &[PlannedGrid<S>],
    bounds: &Aabb<S>,
    class: usize,
) -> usize {
    let mut best = (f64::INFINITY, 0);
    tree.holding(bounds, &mut |grid| {
        let plan = &plans[grid as usize];
        let volume = plan.bounds.size().to_array().into_iter().map(S::to_f64).product::<f64>();
        if grid != 0 && plan.class > class && (volume, grid) < best {
            best = (volume, grid);
        }
    });
    best.1 as usize
}

/// Makes all grids of the plan.
fn fill<S: Scalar>(
    boxes: &[Aabb<S>],
    plans: &[PlannedGrid<S>],
    padding: S,
    settings: &Settings<HugConfig>,
) -> Result<NestedGrids<S>, BuildError> {
    let historical = settings.historical;
    let room = room_of(settings.limits(), settings.max_cells, settings.max_references);
    let rules = BuildRules { historical, room };
    let push = |grids: &mut LooseGrids<S, u32>, plan: &PlannedGrid<S>| {
        let PlannedGrid { ids, inner, .. } = plan;
        let id_boxes: Vec<_> = ids.iter().map(|&i| boxes[i as usize]).collect();
        let inner_boxes: Vec<_> = inner.iter().map(|&g| plans[g as usize].bounds).collect();
        let frame = if historical {
            historical_frame(plan.bounds, plan.own, HISTORICAL_ROUNDING, &rules.room)?
        } else {
            let all = id_boxes.iter().chain(&inner_boxes).copied();
            useful_frame(plan.bounds, all, settings.density, padding, &rules.room)
        };
        grids.push(frame, (ids, &id_boxes), (inner, &inner_boxes), &rules)
    };
    let mut grids = NestedGrids::new();
    grids.push_all(plans, &rules, push, &mut |inner| inner)?;
    Ok(grids)
}

/// s_i (n / volume)^(1/3) voxels an axis and at least one, plus `rounding`, truncated.
pub(super) fn historical_frame<S: Scalar>(
    bounds: Aabb<S>,
    n: usize,
    rounding: f64,
    room: &CapacityLimits,
) -> Result<GridFrame<S>, BuildError> {
    let size = bounds.size().to_array().map(S::to_f64);
    let scale = (n as f64 / size.iter().product::<f64>()).cbrt();
    let most = f64::from(MAX_PER_AXIS);
    let cells = size.map(|s| (s * scale + rounding).clamp(1.0, most) as u32).map(|n| n.max(1));
    let product: u64 = cells.iter().map(|&n| u64::from(n)).product();
    room.check([product, 0])?;
    Ok(GridFrame::new(bounds, cells))
}

/// Cubic cells, `density` for each box; coarser as long as boxes would be listed too often, and
/// one cell where most boxes would be in most cells anyway.
pub(super) fn useful_frame<S: Scalar>(
    bounds: Aabb<S>,
    boxes: impl Iterator<Item = Aabb<S>> + Clone,
    density: f64,
    padding: S,
    room: &CapacityLimits,
) -> GridFrame<S> {
    let n = boxes.clone().count();
    let (most, smallest) = (room.most_cells(), smallest_cell(padding));
    let mut cells = resolve_by_density(bounds, n, density, most, smallest);
    loop {
        let frame = GridFrame::new(bounds, cells);
        let references = references_in(&frame, boxes.clone());
        let n = n as u64;
        if frame.cells() == 1
            || 2 * references <= n * frame.cells() as u64
                && references <= n * REFERENCES_PER_PRIMITIVE
        {
            return frame;
        }
        cells = cells.map(|n| n.div_ceil(2));
    }
}
