//! An eight-wide BVH with exact boxes: a binary tree collapsed, triangles in blocks of eight.
//!
//! Papers: H. Ylitie, T. Karras, S. Laine, "Efficient Incoherent Ray Traversal on GPUs Through
//! Compressed Wide BVHs", HPG 2017 (the collapse, `collapse.rs`); I. Wald, C. Benthin, S. Boulos,
//! "Getting Rid of Packets: Efficient SIMD Single-Ray Traversal using Multi-branching BVHs", RT
//! 2008 (one ray against all boxes of a node; for packets of rays see `packet.rs`). The binary tree
//! is built in `build/`: binned, in Morton order, or with a `preset` by obvhs; over parts of triangles
//! where most are long and thin (`parts.rs`).
//!
//! Deviations: boxes are not compressed; they are in units of the scene's size, and they and rays
//! are padded so that no hit is lost (`node.rs`), where T. Ize, "Robust BVH Ray Traversal", JCGT
//! 2(2), 2013, pads the slabs' rounding alone; the children that a ray meets are sorted by where it
//! enters them or, where any hit ends the query, are in one order for all rays (`collapsed.rs`).

pub(crate) mod build;
mod collapse;
mod collapsed;
pub(crate) mod items;
pub(crate) mod node;
mod node_ray_lanes;
mod packet;
mod parts;
mod prepared;
mod refit;
mod slabs;
mod traverse;

use crate::geometry::aabb::Aabb;
use crate::geometry::ray::Ray;
use crate::geometry::scalar::Scalar;
use crate::parallel;
use crate::params::config::{Config, Settings};
use crate::params::{ParamSpec, Params};
use crate::primitives::{PrimSet, Primitives};
use crate::query::cells::{Cell, CellVisitor, NoCells};
use crate::query::counters::Counters;
use crate::query::kernel::ListBlocks;
use crate::query::lists::{Layout, Lists};
use crate::query::sink::Sink;
use crate::structure::{Batches, BuildError, RayBatch, Structure, StructureInfo, StructureStats};
use crate::update::{Change, REBUILD_AT, REFIT, refitted_until};
use crate::variants::chosen_tests::{SPHERE_TEST, TRIANGLE_TEST};
use build::agglomerated::{preset_named, reinserted};
use build::{BINNED, BUILDS, MORTON, binned, morton};
use collapse::{Collapse, Costs, LEVELS};
use collapsed::CollapsedTree;
use items::{Padding, items_of};
use node::{LEAF, Node, RaySetup, WIDTH};
use parts::{SPLIT, Splitting};

pub static INFO: StructureInfo = StructureInfo {
    name: "wide-bvh",
    summary: "eight-wide BVH with exact boxes, collapsed from a binary tree binned from the top down",
    paper: "Ylitie, Karras, Laine 2017; Wald 2007; Pantaleoni, Luebke 2010; Wald, Benthin, Boulos 2008",
    deviations: "exact boxes; children sorted by distance, for shadow rays in one order (Ize, Hansen 2011); blocks of \
                 triangles; reinsertion by obvhs; thin triangles in parts (Ernst, Greiner 2007)",
    params: &[
        ParamSpec::choice("query", "one", &["one", "batch", PACKETS])
            .about(
                "rays derived one by one, or those of a batch eight at a time, which go together where they run alike",
            ),
        ParamSpec::choice("preset", BINNED, BUILDS)
            .about(
                "the binary tree: binned from the top down, the same over clusters in Morton order (built faster), or \
                 of one of obvhs's build presets",
            ),
        ParamSpec::integer("max-leaf", "16", 1, 64).about("primitives of a leaf at most"),
        ParamSpec::real("node-cost", "1", 0.01, 100.0)
            .about("cost of a visit to a node, that of a block of triangles being 1"),
        SPLIT,
        REFIT,
        REBUILD_AT,
        TRIANGLE_TEST,
        SPHERE_TEST,
        ParamSpec::choice("padding", "default", &["default", "none"]).about(
            "for comparison: none leaves out what keeps rounding from losing boxes that hold hits",
        ),
    ],
    variants: &[""],
    also_tested: &[
        "query=batch",
        "query=packets",
        "preset=morton",
        "preset=medium",
        "preset=fastest",
        "max-leaf=1",
        "max-leaf=4 node-cost=4",
        "split=always",
    ],
    known_defect: |params| {
        (params.text("padding") == "none")
            .then_some("boxes are not padded: hits at their faces are lost to rounding")
    },
    sampled: false,
};

/// How rays are asked about: those of a batch that run alike go together.
const PACKETS: &str = "packets";

/// That of primitives for which [`Padding::OF_CORNERS`] has not been shown to suffice.
const OTHER_PADDING: Padding = Padding::OfExtent { along: 0.0, largest: 5.0 };

/// Returns whether a primitive that ends behind a ray's origin is not hit (`node.rs`).
fn is_exact<S: Scalar>(prims: &dyn Primitives<S>) -> bool {
    size_of::<S>() == size_of::<f32>() && prims.is_watertight()
}

pub struct WideBvh<S: Scalar> {
    nodes: Vec<Node>,
    /// The root: a node or, with [`LEAF`], a list.
    root: u32,
    lists: Lists<S>,
    setup: RaySetup<S>,
    /// How batches of triangles are answered.
    batches: Batches,
    /// True if a primitive that ends behind a ray's origin is not hit: see [`NodeRay`].
    is_exact: bool,
    /// Neither boxes nor rays are padded.
    is_unpadded: bool,
    stats: StructureStats,
    /// With `update=refit`: what a ray was expected to cost when the tree was built.
    built_cost: Option<f64>,
}

/// Settings of the build and of queries.
#[derive(Clone)]
pub struct WideBvhConfig {
    costs: Costs,
    batches: Batches,
    build: Build,
    is_unpadded: bool,
    refitted_until: Option<f64>,
    splitting: Splitting,
}

/// Builder of the binary tree.
#[derive(Clone)]
enum Build {
    Binned,
    Morton,
    Preset(obvhs::BvhBuildParams),
}

impl Config for WideBvhConfig {
    fn of(params: &Params) -> Self {
        let longest_leaf = params.integer("max-leaf") as u32;
        Self {
            costs: Costs { node: params.real("node-cost") as f32, longest_leaf },
            batches: match params.text("query") {
                "batch" => Batches::Together,
                PACKETS => Batches::Packets,
                _ => Batches::RayByRay,
            },
            build: match params.text("preset") {
                BINNED => Build::Binned,
                MORTON => Build::Morton,
                preset => Build::Preset(preset_named(preset)),
            },
            is_unpadded: params.text("padding") == "none",
            refitted_until: refitted_until(params),
            splitting: Splitting::of(params),
        }
    }
}

impl WideBvhConfig {
    /// By how much boxes are padded.
    fn padding<S: Scalar>(&self, prims: &dyn Primitives<S>) -> Padding {
        if self.is_unpadded {
            Padding::Rounding
        } else if is_exact(prims) {
            Padding::OF_CORNERS
        } else {
            OTHER_PADDING
        }
    }
}

impl<S: Scalar> Structure<S> for WideBvh<S> {
    const DUPLICATES: bool = false;

    const HAS_AVX512: bool = true;

    type Config = WideBvhConfig;

    fn build(
        prims: &dyn Primitives<S>,
        settings: &Settings<WideBvhConfig>,
    ) -> Result<Self, BuildError> {
        let structure = settings.structure();
        let (padding, limits) = (settings.padding(prims), settings.limits());
        let items = items_of(prims, limits, padding)?;
        let items = settings.splitting.cut(prims, items, padding, limits)?;
        let longest_leaf = settings.costs.longest_leaf;
        let mut bvh = match settings.build.clone() {
            Build::Binned => binned::tree(&items.boxes, longest_leaf),
            Build::Morton => morton::tree(&items.boxes, longest_leaf),
            Build::Preset(preset) => reinserted(&items.boxes, &preset),
        };
        let collapse = Collapse::plan(&mut bvh, &items.groups, settings.costs, LEVELS);
        let collapsed = CollapsedTree::of(&collapse);
        let leaves = collapsed.leaves();
        let references: u64 = leaves.iter().map(|ids| ids.len() as u64).sum();
        let layout = Layout::of(prims, &leaves, LEAF).ok_or(BuildError::TooLarge {
            structure,
            what: "number of references",
            needed: references.into(),
            limit: LEAF.into(),
        })?;
        let bytes = collapsed.nodes.len() * size_of::<Node>() + layout.bytes::<S>();
        settings.fits(bytes as u128)?;
        let lists = layout.filled(prims, &leaves);
        let place = |place: u32| match place & LEAF {
            0 => place,
            _ => LEAF | layout.numbers[(place & !LEAF) as usize],
        };
        let node = |number: usize| {
            let mut node = Node::empty();
            for (k, child) in collapsed.nodes[number].children().iter().enumerate() {
                let aabb = collapse.bounds(child.subtree);
                node.set_box(k, aabb.min.to_array(), aabb.max.to_array());
                node.children[k] = place(child.place);
            }
            node
        };
        let nodes = parallel::collect(collapsed.nodes.len(), node);
        let stats = StructureStats {
            cells: leaves.len() as u64,
            inner_cells: nodes.len() as u64,
            references,
            bytes: bytes as u64,
            ..StructureStats::default()
        };
        let root = if nodes.is_empty() { place(LEAF) } else { 0 };
        // a child is known by its place among all
        let has_places = !nodes.is_empty() && u32::try_from(nodes.len() * WIDTH).is_ok();
        let batches = match settings.batches {
            Batches::Packets if !has_places => Batches::Together,
            same => same,
        };
        let mut built = Self {
            nodes,
            root,
            lists,
            setup: items.setup,
            batches,
            is_exact: is_exact(prims),
            is_unpadded: settings.is_unpadded,
            stats,
            built_cost: None,
        };
        let is_refitted = settings.refitted_until.is_some();
        built.built_cost = is_refitted.then(|| built.expected_cost(settings.costs));
        Ok(built)
    }

    fn update(
        &mut self,
        prims: &dyn Primitives<S>,
        settings: &Settings<WideBvhConfig>,
        moved: &[u32],
    ) -> Result<Change, BuildError> {
        if let (Some(built), Some(until)) = (self.built_cost, settings.refitted_until)
            && let Some(cost) = self.refit(prims, settings, moved)
            && cost <= until * built
        {
            return Ok(Change::Updated);
        }
        *self = Self::build(prims, settings)?;
        Ok(Change::Rebuilt)
    }

    #[inline(always)]
    fn traverse<K: Sink<S>>(&self, ray: &Ray<S>, sink: &mut K) {
        self.traverse_ray(ray, sink);
    }

    #[inline(always)]
    fn batches<P: PrimSet<S>>(&self, _: &P, _: Option<&ListBlocks<S>>) -> Batches {
        if P::HAS_BLOCKS && !self.is_unpadded { self.batches } else { Batches::RayByRay }
    }

    #[inline(always)]
    fn answer_batch<P: PrimSet<S>, C: Counters>(
        &self,
        prims: &P,
        _: Option<&ListBlocks<S>>,
        batch: RayBatch<'_, S>,
    ) -> C {
        self.answer_prepared(prims, batch)
    }

    fn stats(&self) -> StructureStats {
        self.stats
    }

    /// The root, whose box rays are not tested against, is shown as large as its children.
    fn cells(&self, each: &mut CellVisitor<'_>) -> Result<(), NoCells> {
        let mut ids = Vec::new();
        let children = |number: u32| {
            let node = &self.nodes[number as usize];
            let child = |k| Some((node.children[k], self.setup.world(node.child_box(k)?)));
            (0..WIDTH).filter_map(child).collect::<Vec<_>>()
        };
        let bounds = match self.root & LEAF {
            0 => children(self.root).iter().fold(Aabb::empty(), |all, (_, b)| all.union(*b)),
            _ => Aabb::everything(),
        };
        let mut waiting = vec![(self.root, bounds, 0)];
        while let Some((at, bounds, depth)) = waiting.pop() {
            if at & LEAF != 0 {
                self.lists.ids(at & !LEAF, &mut ids);
                each(Cell::elementary(bounds, depth, &ids));
                continue;
            }
            each(Cell::inner(bounds, depth));
            waiting.extend(children(at).into_iter().rev().map(|(at, b)| (at, b, depth + 1)));
        }
        Ok(())
    }
}
