//! The binary BVH of the `obvhs` crate: PLOC with reinsertion, the modern baseline.
//!
//! Papers: D. Meister, J. Bittner, "Parallel Locally-Ordered Clustering for Bounding Volume
//! Hierarchy Construction", TVCG 2018, and "Parallel Reinsertion for Bounding Volume Hierarchy
//! Optimization", 2018, as implemented by obvhs 0.4. Its builder and its traversal are used;
//! primitives are tested by our own sets. See `adapter.rs` for the robust adapter, and
//! `builder.rs` for scenes that the builder does not serve.

use obvhs::aabb::Aabb as ObvhsAabb;
use obvhs::bvh2::{Bvh2, node::Bvh2Node};
use obvhs::fast_stack;
use obvhs::ray::{Ray as ObvhsRay, RayHit};

use crate::geometry::ray::Ray;
use crate::geometry::scalar::Scalar;
use crate::params::config::Settings;
use crate::primitives::{PrimSet, TriangleBlock, blocks};
use crate::query::cells::{Cell, CellVisitor, NoCells};
use crate::query::kernel::ListBlocks;
use crate::query::sink::Sink;
use crate::structure::{
    BatchAnswers, Batches, BuildError, Structure, StructureInfo, StructureStats,
};
use crate::structures::obvhs::adapter::{
    ADAPTER, ALSO_TESTED, AdapterConfig, DEVIATIONS, KERNEL, PRESET, VARIANTS, known_defect,
};
use crate::structures::obvhs::box_ray::{BoxRay, Length, RaySetup};
use crate::structures::obvhs::builder;
use crate::structures::obvhs::direct::{self, DirectQueries};
use crate::structures::obvhs::items::{self, BoxScale, Groups, Items, items};
use crate::structures::obvhs::{direct_builder, leaf_blocks, refit};
use crate::update::{Change, MovedIds, REBUILD_AT, REFIT};

pub static INFO: StructureInfo = StructureInfo {
    name: "obvhs-bvh2",
    summary: "binary BVH of the obvhs crate (PLOC, reinsertion)",
    paper: "Meister, Bittner 2018 (two papers); obvhs 0.4",
    deviations: DEVIATIONS,
    params: &[
        PRESET,
        ADAPTER,
        KERNEL,
        REFIT,
        REBUILD_AT,
        #[cfg(feature = "compiled-tests")]
        crate::structures::obvhs::adapter::PADDING,
    ],
    variants: VARIANTS,
    also_tested: ALSO_TESTED,
    known_defect,
    sampled: false,
};

/// obvhs's `Bvh2` over our primitives.
pub struct ObvhsBvh2<S: Scalar> {
    bvh: Bvh2,
    groups: Groups,
    /// In place of ids, where the triangles are in blocks: leaves then begin at the number of one.
    blocks: Option<Vec<TriangleBlock<S>>>,
    setup: RaySetup<S>,
    /// With `adapter=direct`, where it serves the set.
    direct: Option<DirectQueries>,
    /// With `update=refit`: what a ray was expected to cost when the tree was built.
    built_cost: Option<f64>,
}

impl<S: Scalar> Structure<S> for ObvhsBvh2<S> {
    const DUPLICATES: bool = false;

    type Config = AdapterConfig;

    fn build<P: PrimSet<S>>(
        prims: &P,
        settings: &Settings<AdapterConfig>,
    ) -> Result<Self, BuildError> {
        if settings.is_direct
            && let Some(triangles) = direct::triangles(prims)
        {
            let bvh = direct_builder::binary(&triangles, &settings.preset);
            let direct = Some(DirectQueries::new(prims, &bvh, &triangles));
            let (groups, setup) = (Groups::Single, RaySetup::AsShipped);
            let built_cost = settings.refitted_until.map(|_| refit::expected_cost(&bvh));
            return Ok(Self { bvh, groups, blocks: None, setup, direct, built_cost });
        }
        let items = items(prims, settings)?;
        let robust = items.setup.is_robust();
        let mut bvh = builder::binary(&items.boxes, &settings.preset, robust);
        let Items { groups, setup, .. } = items;
        let is_block = leaf_blocks::serve(prims, &groups, settings);
        if is_block {
            // the leaves of a binary tree
            leaf_blocks::fit::<S>(bvh.nodes.len() / 2 + 1, settings.limits())?;
        }
        let blocks = is_block.then(|| leaf_blocks::of_binary(&mut bvh, prims));
        let built_cost = settings.refitted_until.map(|_| refit::expected_cost(&bvh));
        Ok(Self { bvh, groups, blocks, setup, direct: None, built_cost })
    }

    fn update<P: PrimSet<S>>(
        &mut self,
        prims: &P,
        settings: &Settings<AdapterConfig>,
        moved: &[u32],
    ) -> Result<Change, BuildError> {
        if let (Some(built), Some(until)) = (self.built_cost, settings.refitted_until)
            && self.refit(prims, settings, moved)?
            && refit::expected_cost(&self.bvh) <= until * built
        {
            return Ok(Change::Updated);
        }
        *self = Self::build(prims, settings)?;
        Ok(Change::Rebuilt)
    }

    #[inline(always)]
    fn traverse<K: Sink<S>>(&self, ray: &Ray<S>, sink: &mut K) {
        let start = self.setup.ray(ray, Length::Unit);
        let of_boxes = start.for_obvhs(&self.setup, ray, sink.t_max());
        if K::COUNTING {
            count_nodes(&self.bvh, of_boxes, |node, r| self.leaf(node, r, &start, sink));
            return;
        }
        let mut leaf = |node: &Bvh2Node, r: &mut ObvhsRay, _: &mut RayHit| {
            self.leaf(Some(node), r, &start, sink)
        };
        let mut none = RayHit::none();
        fast_stack!(u32, (96, 192), self.bvh.max_depth, stack, {
            self.bvh.ray_traverse_dynamic(&mut stack, of_boxes, &mut none, &mut leaf);
        });
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
        let cells = self.bvh.nodes.iter().filter(|n| n.is_leaf()).count() as u64;
        let ids = self.bvh.primitive_indices.iter();
        let references = match &self.blocks {
            Some(blocks) => leaf_blocks::references(blocks),
            None => ids.map(|i| self.groups.ids(i).len() as u64).sum(),
        };
        let blocks = self.blocks.as_deref().map_or(0, size_of_val) as u64;
        StructureStats {
            inner_cells: self.bvh.nodes.len() as u64 - cells,
            cells,
            empty_cells: 0,
            references,
            resolution: None,
            bytes: (size_of_val(self.bvh.nodes.as_slice())
                + size_of_val(self.bvh.primitive_indices.as_slice())) as u64
                + self.groups.bytes()
                + blocks
                + self.direct.as_ref().map_or(0, DirectQueries::bytes),
            ..StructureStats::default()
        }
    }

    fn cells(&self, each: &mut CellVisitor<'_>) -> Result<(), NoCells> {
        let mut ids = Vec::new();
        let mut waiting = vec![(0, 0)];
        while let Some((number, depth)) = waiting.pop() {
            let node: &Bvh2Node = &self.bvh.nodes[number as usize];
            let b = node.aabb();
            let bounds = self.setup.world([b.min.to_array(), b.max.to_array()]);
            let first = node.first_index;
            if !node.is_leaf() {
                each(Cell::inner(bounds, depth));
                waiting.extend([(first + 1, depth + 1), (first, depth + 1)]);
                continue;
            }
            match &self.blocks {
                Some(all) => blocks::ids_of_list(&all[first as usize..], &mut ids),
                None => {
                    let items = &self.bvh.primitive_indices[first as usize..];
                    let items = items.iter().take(node.prim_count as usize);
                    ids.extend(items.flat_map(|item| self.groups.ids(item)));
                }
            }
            each(Cell::elementary(bounds, depth, &ids));
            ids.clear();
        }
        Ok(())
    }
}

impl<S: Scalar> ObvhsBvh2<S> {
    /// Fits the boxes, and triangles that the tree has copies of, to primitives of which some stand
    /// elsewhere now. False where these would be kept in another way, and nothing was done.
    fn refit<P: PrimSet<S>>(
        &mut self,
        prims: &P,
        settings: &Settings<AdapterConfig>,
        moved: &[u32],
    ) -> Result<bool, BuildError> {
        let triangles = if settings.is_direct { direct::triangles(prims) } else { None };
        let is_block = leaf_blocks::serve(prims, &self.groups, settings);
        if triangles.is_some() != self.direct.is_some()
            || self.direct.is_none() && is_block != self.blocks.is_some()
        {
            return Ok(false);
        }
        if let Some(triangles) = triangles {
            refit::refit(&mut self.bvh, |bvh, leaf| {
                let ids = leaf_items(bvh, leaf).iter();
                ids.fold(ObvhsAabb::empty(), |all, &id| all.union(&triangles[id as usize].aabb()))
            });
            self.direct = Some(DirectQueries::new(prims, &self.bvh, &triangles));
            return Ok(true);
        }
        let scale = BoxScale::of_set(prims, settings.structure(), items::padding_of(settings))?;
        let moved = MovedIds::new(moved);
        let is_same = scale.serves(&self.setup);
        self.setup = scale.setup;
        let fitted = |ids: &[u32], before: &ObvhsAabb| {
            if is_same && !ids.iter().any(|&id| moved.has(id)) {
                *before
            } else {
                scale.around(prims, ids)
            }
        };
        let mut ids = Vec::new();
        if let Some(all) = &mut self.blocks {
            blocks::refresh(prims, all, &moved);
            refit::refit(&mut self.bvh, |bvh, leaf| {
                ids.clear();
                let leaf = &bvh.nodes[leaf];
                blocks::ids_of_list(&all[leaf.first_index as usize..], &mut ids);
                fitted(&ids, leaf.aabb())
            });
        } else {
            let groups = &self.groups;
            refit::refit(&mut self.bvh, |bvh, leaf| {
                ids.clear();
                let items = leaf_items(bvh, leaf).iter();
                items.for_each(|item| ids.extend_from_slice(groups.ids(item)));
                fitted(&ids, bvh.nodes[leaf].aabb())
            });
        }
        Ok(true)
    }

    /// Tests a leaf's primitives (or reports an inner node, `None`); false ends the traversal.
    #[inline(always)]
    fn leaf<K: Sink<S>>(
        &self,
        node: Option<&Bvh2Node>,
        ray: &mut ObvhsRay,
        start: &BoxRay<S>,
        sink: &mut K,
    ) -> bool {
        let Some(node) = node else {
            sink.inner_step();
            return true;
        };
        sink.elementary_step(false);
        let first = node.first_index as usize;
        let tested = match &self.blocks {
            Some(blocks) => sink.test_blocks(&blocks[first..]),
            None => self.bvh.primitive_indices[first..first + node.prim_count as usize]
                .iter()
                .try_for_each(|item| sink.test(self.groups.ids(item))),
        };
        if tested.is_break() {
            return false;
        }
        ray.tmax = start.parameters.bound(sink.t_max());
        true
    }
}

/// Items of a leaf.
fn leaf_items(bvh: &Bvh2, leaf: usize) -> &[u32] {
    let (first, count) = (bvh.nodes[leaf].first_index, bvh.nodes[leaf].prim_count);
    &bvh.primitive_indices[first as usize..][..count as usize]
}

/// Visits nodes in the order obvhs does, reporting inner nodes as well (`None`): only for
/// counting, so that the timed traversal is the library's own. A test compares both with each
/// other. A pair's leaves are tested at once, its inner nodes near one first; a node that waits on
/// the stack is not tested against the shrunken ray again.
fn count_nodes(
    bvh: &Bvh2,
    mut ray: ObvhsRay,
    mut visit: impl FnMut(Option<&Bvh2Node>, &mut ObvhsRay) -> bool,
) {
    let Some(root) = bvh.nodes.first() else { return };
    if root.aabb().intersect_ray(&ray) >= ray.tmax {
        return;
    }
    if root.is_leaf() {
        visit(Some(root), &mut ray);
        return;
    }
    let mut waiting = vec![root.first_index];
    while let Some(pair) = waiting.pop() {
        visit(None, &mut ray);
        let both = &bvh.nodes[pair as usize..pair as usize + 2];
        let entry = [both[0].aabb().intersect_ray(&ray), both[1].aabb().intersect_ray(&ray)];
        let near_first = if entry[0] > entry[1] { [1, 0] } else { [0, 1] };
        let waiting_before = waiting.len();
        for i in near_first {
            if entry[i] < ray.tmax {
                if !both[i].is_leaf() {
                    waiting.push(both[i].first_index);
                } else if !visit(Some(&both[i]), &mut ray) {
                    return;
                }
            }
        }
        waiting[waiting_before..].reverse();
    }
}
