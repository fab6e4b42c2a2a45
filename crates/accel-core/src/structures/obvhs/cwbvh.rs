//! The compressed 8-wide BVH of the `obvhs` crate.
//!
//! Paper: H. Ylitie, T. Karras, S. Laine, "Efficient Incoherent Ray Traversal on GPUs Through
//! Compressed Wide BVHs", HPG 2017, as implemented by obvhs 0.4. By its plain name it is the
//! library as its authors use it (`direct.rs`); with `adapter=robust` its answers are right: see
//! `mod.rs`, and `builder.rs` for scenes that its builder does not serve.

use std::ops::ControlFlow;

use glam::UVec2;
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb as ObvhsAabb;
use obvhs::cwbvh::{CwBvh, Traversal};
use obvhs::ray::Ray as ObvhsRay;

use crate::bvh::build::agglomerated::{agglomerated, preset_named};
use crate::bvh::items::{Groups, Items, Padding, items_of};
use crate::bvh::node::{Length, RaySetup};
use crate::config;
use crate::geometry::aabb::Aabb;
use crate::geometry::ray::Ray;
use crate::geometry::scalar::Scalar;
use crate::params::config::Settings;
use crate::primitives::{Primitives, TriangleBlock};
use crate::query::cells::{Cell, CellVisitor, NoCells};
use crate::query::sink::Sink;
use crate::structure::{BuildError, Structure, StructureInfo, StructureStats};
use crate::structures::obvhs::builder::{self, DepthError};
use crate::structures::obvhs::direct::{self, DirectQueries, direct_batches};
use crate::structures::obvhs::leaf_blocks;
use crate::structures::obvhs::{ADAPTER, DEVIATIONS, DIRECT_DEFECT, KERNEL, PRESET};

pub static INFO: StructureInfo = StructureInfo {
    paper: "Ylitie, Karras, Laine 2017; obvhs 0.4",
    deviations: DEVIATIONS,
    params: CwBvhConfig::PARAMS,
    variants: &["", "preset=fastest"],
    also_tested: &[
        "preset=very-slow",
        "adapter=robust",
        "adapter=robust kernel=scalar",
        "adapter=robust preset=fastest",
        "adapter=robust preset=fastest kernel=scalar",
        "adapter=robust preset=very-fast",
        "adapter=robust preset=fast",
        "adapter=robust preset=slow",
        "adapter=robust preset=very-slow",
    ],
    known_defect: |params| (params.text(ADAPTER.name) == "direct").then_some(DIRECT_DEFECT),
    ..StructureInfo::new(
        "obvhs-cwbvh",
        "compressed 8-wide BVH of the obvhs crate, as its authors use it",
    )
};

config! {
    /// Settings of the build and of queries.
    pub struct CwBvhConfig {
        preset: BvhBuildParams = PRESET => preset_named,
        is_robust: bool = ADAPTER => |adapter| adapter == "robust",
        has_blocks: bool = KERNEL => |kernel| kernel == "block",
    }
}

/// obvhs's `CwBvh`.
pub struct ObvhsCwBvh<S: Scalar> {
    bvh: CwBvh,
    leaves: Leaves<S>,
}

/// Primitives of the tree's leaves, and how rays are told to it.
enum Leaves<S: Scalar> {
    /// Its own triangles, as its authors use it.
    Direct(DirectQueries),
    /// Our primitives by their ids, where its own triangles do not serve the set.
    Callback,
    /// With `adapter=robust`.
    Robust {
        setup: RaySetup<S>,
        groups: Groups,
        /// In place of ids, where triangles are in blocks: a node's begin at the number of one.
        blocks: Option<Vec<TriangleBlock<S>>>,
    },
}

impl<S: Scalar> Structure<S> for ObvhsCwBvh<S> {
    const DUPLICATES: bool = false;

    type Config = CwBvhConfig;

    fn build(
        prims: &dyn Primitives<S>,
        settings: &Settings<CwBvhConfig>,
    ) -> Result<Self, BuildError> {
        let too_deep = |DepthError { needed, limit }| BuildError::TooLarge {
            structure: settings.structure(),
            what: "depth of obvhs's CwBvh",
            needed: u128::from(needed),
            limit: u128::from(limit),
        };
        let (preset, limits) = (settings.preset, settings.limits());
        let wide =
            |tree, is_robust| builder::eight_wide(tree, &preset, is_robust).map_err(too_deep);
        if settings.is_robust {
            let Items { boxes, groups, setup } = items_of(prims, limits, Padding::OfScene)?;
            let mut bvh = wide(agglomerated(&boxes, &preset, true), true)?;
            let has_blocks = settings.has_blocks && leaf_blocks::serve(prims, &groups);
            if has_blocks {
                leaf_blocks::fit::<S>(bvh.nodes.len(), limits)?;
            }
            let blocks = has_blocks.then(|| leaf_blocks::of_wide(&mut bvh, prims));
            return Ok(Self { bvh, leaves: Leaves::Robust { setup, groups, blocks } });
        }
        let (tree, triangles) = direct::tree(prims, limits, &preset)?;
        let bvh = wide(tree, false)?;
        let direct = triangles.map(|own| DirectQueries::new(prims, &bvh, &own));
        let leaves = direct.map_or(Leaves::Callback, Leaves::Direct);
        Ok(Self { bvh, leaves })
    }

    #[inline(always)]
    fn traverse<K: Sink<S>>(&self, ray: &Ray<S>, sink: &mut K) {
        let Leaves::Robust { setup, groups, blocks } = &self.leaves else {
            let bound = |t_max: S| t_max.to_f64() as f32;
            return self.traverse_with(direct::own(ray), sink, bound, |state, sink| {
                let id = self.bvh.primitive_indices[state.primitive_id as usize];
                sink.test(&[id])
            });
        };
        let start = setup.ray(ray, Length::Brief);
        let of_boxes = start.for_obvhs(sink.t_max());
        let bound = |t_max| start.parameters.bound(t_max);
        match blocks {
            Some(blocks) => self.traverse_with(of_boxes, sink, bound, |state, sink| {
                let first = state.primitive_group.x;
                let (block, bits) = leaf_blocks::block_of(state.primitive_id, first);
                state.primitive_group.y &= !bits;
                sink.test_block(&blocks[block])
            }),
            None => self.traverse_with(of_boxes, sink, bound, |state, sink| {
                let item = &self.bvh.primitive_indices[state.primitive_id as usize];
                sink.test(groups.ids(item))
            }),
        }
    }

    direct_batches!();

    fn stats(&self) -> StructureStats {
        let children = self.bvh.nodes.iter().flat_map(|n| (0..8).map(move |c| (n, c)));
        let cells = children.filter(|(n, c)| n.is_leaf(*c) && !n.is_child_empty(*c)).count();
        let indices = self.bvh.primitive_indices.as_slice();
        let (references, bytes) = match &self.leaves {
            Leaves::Direct(own) => (indices.len() as u64, own.bytes()),
            Leaves::Callback => (indices.len() as u64, 0),
            Leaves::Robust { blocks: Some(blocks), .. } => {
                (leaf_blocks::references(blocks), size_of_val(blocks.as_slice()) as u64)
            }
            Leaves::Robust { groups, .. } => {
                (indices.iter().map(|i| groups.ids(i).len() as u64).sum(), groups.bytes())
            }
        };
        StructureStats {
            inner_cells: self.bvh.nodes.len() as u64,
            cells: cells as u64,
            references,
            bytes: (size_of_val(self.bvh.nodes.as_slice()) + size_of_val(indices)) as u64 + bytes,
            ..StructureStats::default()
        }
    }

    /// Boxes of children are those that their node has compressed.
    fn cells(&self, each: &mut CellVisitor<'_>) -> Result<(), NoCells> {
        let unit = match &self.leaves {
            Leaves::Robust { setup, .. } => setup.unit(),
            _ => 1.0,
        };
        let world = |b: ObvhsAabb| -> Aabb<f64> {
            Aabb { min: b.min.as_dvec3() / unit, max: b.max.as_dvec3() / unit }
        };
        let mut ids = Vec::new();
        // a node, and the leaf that is one of its children
        let mut waiting = vec![(0, None, world(self.bvh.total_aabb), 0)];
        while let Some((number, leaf, bounds, depth)) = waiting.pop() {
            let node = &self.bvh.nodes[number as usize];
            if let Some(leaf) = leaf {
                let (first, count) = node.child_primitives(leaf);
                for at in first..first + count {
                    match &self.leaves {
                        Leaves::Robust { blocks: Some(blocks), .. } => {
                            let (block, _) = leaf_blocks::block_of(at, node.primitive_base_idx);
                            let lane = at as usize % TriangleBlock::<S>::LANES;
                            ids.push(blocks[block].ids().0[lane]);
                        }
                        Leaves::Robust { groups, .. } => {
                            ids.extend(groups.ids(&self.bvh.primitive_indices[at as usize]));
                        }
                        _ => ids.push(self.bvh.primitive_indices[at as usize]),
                    }
                }
                each(Cell::elementary(bounds, depth, &ids));
                ids.clear();
                continue;
            }
            each(Cell::inner(bounds, depth));
            for child in (0..8).rev().filter(|child| !node.is_child_empty(*child)) {
                let bounds = world(node.child_aabb(child));
                let (number, leaf) = if node.is_leaf(child) {
                    (number, Some(child))
                } else {
                    (node.child_node_index(child), None)
                };
                waiting.push((number, leaf, bounds, depth + 1));
            }
        }
        Ok(())
    }
}

impl<S: Scalar> ObvhsCwBvh<S> {
    #[inline(always)]
    fn direct(&self) -> Option<&DirectQueries> {
        if let Leaves::Direct(own) = &self.leaves { Some(own) } else { None }
    }

    /// The library's loop; `test` tests the primitive at which it is, `bound` says where a query
    /// ends as a parameter of `ray`.
    #[inline(always)]
    fn traverse_with<K: Sink<S>>(
        &self,
        mut ray: ObvhsRay,
        sink: &mut K,
        bound: impl Fn(S) -> f32,
        test: impl Fn(&mut Traversal, &mut K) -> ControlFlow<()>,
    ) {
        let mut state = self.bvh.new_traversal(ray.direction);
        let mut node;
        'traversal: {
            obvhs::traverse!(
                self.bvh,
                node,
                state,
                {
                    sink.inner_step();
                    node.intersect_ray(&ray, state.oct_inv4)
                },
                {
                    sink.elementary_step(false);
                    if test(&mut state, sink).is_break() {
                        break 'traversal;
                    }
                    ray.tmax = bound(sink.t_max());
                }
            );
        }
    }
}
