//! The compressed 8-wide BVH of the `obvhs` crate.
//!
//! Paper: H. Ylitie, T. Karras, S. Laine, "Efficient Incoherent Ray Traversal on GPUs Through
//! Compressed Wide BVHs", HPG 2017, as implemented by obvhs 0.4. Its builder, node test and
//! traversal are used; primitives are tested by our own sets. See `adapter.rs`, and
//! `builder.rs` for scenes that the builder does not serve.

use std::ops::ControlFlow;

use glam::UVec2;
use obvhs::aabb::Aabb as ObvhsAabb;
use obvhs::cwbvh::{CwBvh, Traversal};

use crate::geometry::ray::Ray;
use crate::geometry::scalar::Scalar;
use crate::params::config::Settings;
use crate::primitives::{PrimSet, TriangleBlock};
use crate::query::cells::{Cell, CellVisitor, NoCells};
use crate::query::kernel::ListBlocks;
use crate::query::sink::Sink;
use crate::structure::{
    BatchAnswers, Batches, BuildError, Structure, StructureInfo, StructureStats,
};
use crate::structures::obvhs::adapter::{
    ADAPTER, ALSO_TESTED, AdapterConfig, DEVIATIONS, KERNEL, PRESET, VARIANTS, known_defect,
};
use crate::structures::obvhs::box_ray::{Length, RaySetup};
use crate::structures::obvhs::builder::{DepthError, eight_wide};
use crate::structures::obvhs::direct::{self, DirectQueries};
use crate::structures::obvhs::items::{Groups, Items, items};
use crate::structures::obvhs::{direct_builder, leaf_blocks};

pub static INFO: StructureInfo = StructureInfo {
    name: "obvhs-cwbvh",
    summary: "compressed 8-wide BVH of the obvhs crate",
    paper: "Ylitie, Karras, Laine 2017; obvhs 0.4",
    deviations: DEVIATIONS,
    params: &[
        PRESET,
        ADAPTER,
        KERNEL,
        #[cfg(feature = "compiled-tests")]
        crate::structures::obvhs::adapter::PADDING,
    ],
    variants: VARIANTS,
    also_tested: ALSO_TESTED,
    known_defect,
    sampled: false,
};

/// obvhs's `CwBvh` over our primitives.
pub struct ObvhsCwBvh<S: Scalar> {
    bvh: CwBvh,
    groups: Groups,
    /// In place of ids, where the triangles are in blocks: a node's then begin at the number of
    /// one.
    blocks: Option<Vec<TriangleBlock<S>>>,
    setup: RaySetup<S>,
    /// With `adapter=direct`, where it serves the set.
    direct: Option<DirectQueries>,
}

impl<S: Scalar> Structure<S> for ObvhsCwBvh<S> {
    const DUPLICATES: bool = false;

    type Config = AdapterConfig;

    fn build<P: PrimSet<S>>(
        prims: &P,
        settings: &Settings<AdapterConfig>,
    ) -> Result<Self, BuildError> {
        let too_deep = |DepthError { needed, limit }| BuildError::TooLarge {
            structure: settings.structure(),
            what: "depth of obvhs's CwBvh",
            needed: u128::from(needed),
            limit: u128::from(limit),
        };
        let preset = settings.preset;
        if settings.is_direct
            && let Some(triangles) = direct::triangles(prims)
        {
            let bvh = direct_builder::eight_wide(&triangles, &preset).map_err(too_deep)?;
            let direct = Some(DirectQueries::new(prims, &bvh, &triangles));
            let (groups, setup) = (Groups::Single, RaySetup::AsShipped);
            return Ok(Self { bvh, groups, blocks: None, setup, direct });
        }
        let items = items(prims, settings)?;
        let Items { boxes, groups, setup } = items;
        let mut bvh = eight_wide(&boxes, &preset, setup.is_robust()).map_err(too_deep)?;
        let is_block = leaf_blocks::serve(prims, &groups, settings);
        if is_block {
            leaf_blocks::fit::<S>(bvh.nodes.len(), settings.limits())?;
        }
        let blocks = is_block.then(|| leaf_blocks::of_wide(&mut bvh, prims));
        Ok(Self { bvh, groups, blocks, setup, direct: None })
    }

    #[inline(always)]
    fn traverse<K: Sink<S>>(&self, ray: &Ray<S>, sink: &mut K) {
        match &self.blocks {
            Some(blocks) => self.traverse_with(ray, sink, |state, sink| {
                let first = state.primitive_group.x;
                let (block, bits) = leaf_blocks::block_of(state.primitive_id, first);
                state.primitive_group.y &= !bits;
                sink.test_block(&blocks[block])
            }),
            None => self.traverse_with(ray, sink, |state, sink| {
                let item = &self.bvh.primitive_indices[state.primitive_id as usize];
                sink.test(self.groups.ids(item))
            }),
        }
    }

    #[inline(always)]
    fn batches<P: PrimSet<S>>(&self, prims: &P, _: Option<&ListBlocks<S>>) -> Batches {
        DirectQueries::batches::<S, P>(self.direct.as_ref(), prims)
    }

    #[inline(always)]
    fn answer_batch<P: PrimSet<S>>(
        &self,
        _: &P,
        _: Option<&ListBlocks<S>>,
        rays: &[Ray<S>],
        _: S,
        answers: BatchAnswers<'_, S>,
    ) {
        if let Some(own) = &self.direct {
            own.answer_batch(&self.bvh, rays, answers);
        }
    }

    fn stats(&self) -> StructureStats {
        let cells = self
            .bvh
            .nodes
            .iter()
            .flat_map(|n| (0..8).map(move |c| (n, c)))
            .filter(|(n, c)| n.is_leaf(*c) && !n.is_child_empty(*c))
            .count();
        let indices = self.bvh.primitive_indices.as_slice();
        StructureStats {
            inner_cells: self.bvh.nodes.len() as u64,
            cells: cells as u64,
            empty_cells: 0,
            references: match &self.blocks {
                Some(blocks) => leaf_blocks::references(blocks),
                None => indices.iter().map(|i| self.groups.ids(i).len() as u64).sum(),
            },
            resolution: None,
            bytes: (size_of_val(self.bvh.nodes.as_slice()) + size_of_val(indices)) as u64
                + self.groups.bytes()
                + self.blocks.as_deref().map_or(0, size_of_val) as u64
                + self.direct.as_ref().map_or(0, DirectQueries::bytes),
            ..StructureStats::default()
        }
    }

    /// Boxes of children are those that their node has compressed.
    fn cells(&self, each: &mut CellVisitor<'_>) -> Result<(), NoCells> {
        let world = |b: ObvhsAabb| self.setup.world([b.min.to_array(), b.max.to_array()]);
        let mut ids = Vec::new();
        // a node, and the leaf that is one of its children
        let mut waiting = vec![(0, None, world(self.bvh.total_aabb), 0)];
        while let Some((number, leaf, bounds, depth)) = waiting.pop() {
            let node = &self.bvh.nodes[number as usize];
            if let Some(leaf) = leaf {
                let (first, count) = node.child_primitives(leaf);
                for at in first..first + count {
                    match &self.blocks {
                        Some(blocks) => {
                            let (block, _) = leaf_blocks::block_of(at, node.primitive_base_idx);
                            ids.push(
                                blocks[block].ids().0[at as usize % TriangleBlock::<S>::LANES],
                            );
                        }
                        None => {
                            let item = &self.bvh.primitive_indices[at as usize];
                            ids.extend(self.groups.ids(item));
                        }
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
    /// [`Structure::traverse`]; `test` tests the primitive at which the traversal is.
    #[inline(always)]
    fn traverse_with<K: Sink<S>>(
        &self,
        ray: &Ray<S>,
        sink: &mut K,
        test: impl Fn(&mut Traversal, &mut K) -> ControlFlow<()>,
    ) {
        let start = self.setup.ray(ray, Length::Brief);
        let mut ray = start.for_obvhs(&self.setup, ray, sink.t_max());
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
                    ray.tmax = start.parameters.bound(sink.t_max());
                }
            );
        }
    }
}
