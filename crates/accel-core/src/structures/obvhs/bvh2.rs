//! The binary BVH of the `obvhs` crate as its authors use it: PLOC with reinsertion.
//!
//! Papers: D. Meister, J. Bittner, "Parallel Locally-Ordered Clustering for Bounding Volume
//! Hierarchy Construction", TVCG 2018, and "Parallel Reinsertion for Bounding Volume Hierarchy
//! Optimization", 2018, as implemented by obvhs 0.4. See `direct.rs`, and `mod.rs` for its
//! defects.

use std::marker::PhantomData;

use crate::bvh::build::agglomerated::preset_named;
use crate::geometry::aabb::Aabb;
use crate::geometry::ray::Ray;
use crate::geometry::scalar::Scalar;
use crate::params::Params;
use crate::params::config::{Config, Settings};
use crate::primitives::Primitives;
use crate::query::cells::{Cell, CellVisitor, NoCells};
use crate::query::sink::Sink;
use crate::structure::{BuildError, Structure, StructureInfo, StructureStats};
use crate::structures::obvhs::builder;
use crate::structures::obvhs::direct::{self, DirectQueries, direct_batches};
use crate::structures::obvhs::{DEVIATIONS, DIRECT_DEFECT, PRESET};
use crate::update::{Change, REBUILD_AT, REFIT, refitted_until};
use obvhs::aabb::Aabb as ObvhsAabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::node::Bvh2Node;
use obvhs::ray::{Ray as ObvhsRay, RayHit};
use obvhs::{BvhBuildParams, fast_stack};

pub static INFO: StructureInfo = StructureInfo {
    paper: "Meister, Bittner 2018 (two papers); obvhs 0.4",
    deviations: DEVIATIONS,
    params: &[PRESET, REFIT, REBUILD_AT],
    variants: &["", "preset=fastest"],
    also_tested: &["preset=very-fast", "preset=fast", "preset=slow", "preset=very-slow"],
    known_defect: |_| Some(DIRECT_DEFECT),
    ..StructureInfo::new(
        "obvhs-bvh2",
        "binary BVH of the obvhs crate (PLOC, reinsertion), as its authors use it",
    )
};

/// Settings of the build.
#[derive(Clone)]
pub struct Bvh2Config {
    preset: BvhBuildParams,
    refitted_until: Option<f64>,
}

impl Config for Bvh2Config {
    fn of(params: &Params) -> Self {
        Self {
            preset: preset_named(params.text(PRESET.name)),
            refitted_until: refitted_until(params),
        }
    }
}

/// obvhs's `Bvh2` over its own triangles, or over our primitives.
pub struct ObvhsBvh2<S> {
    bvh: Bvh2,
    /// Its own triangles, where they serve the set.
    direct: Option<DirectQueries>,
    /// With `update=refit`: what a ray was expected to cost when the tree was built.
    built_cost: Option<f64>,
    scalar: PhantomData<S>,
}

impl<S: Scalar> Structure<S> for ObvhsBvh2<S> {
    const DUPLICATES: bool = false;

    type Config = Bvh2Config;

    fn build(
        prims: &dyn Primitives<S>,
        settings: &Settings<Bvh2Config>,
    ) -> Result<Self, BuildError> {
        let (tree, triangles) = direct::tree(prims, settings.limits(), &settings.preset)?;
        let bvh = builder::binary(tree, &settings.preset);
        let direct = triangles.map(|own| DirectQueries::new(prims, &bvh, &own));
        let built_cost = settings.refitted_until.map(|_| expected_cost(&bvh));
        Ok(Self { bvh, direct, built_cost, scalar: PhantomData })
    }

    fn update(
        &mut self,
        prims: &dyn Primitives<S>,
        settings: &Settings<Bvh2Config>,
        _moved: &[u32],
    ) -> Result<Change, BuildError> {
        if let (Some(built), Some(until)) = (self.built_cost, settings.refitted_until)
            && self.refit_all(prims)
            && expected_cost(&self.bvh) <= until * built
        {
            return Ok(Change::Updated);
        }
        *self = Self::build(prims, settings)?;
        Ok(Change::Rebuilt)
    }

    #[inline(always)]
    fn traverse<K: Sink<S>>(&self, ray: &Ray<S>, sink: &mut K) {
        let of_boxes = direct::own(ray);
        if K::COUNTING {
            count_nodes(&self.bvh, of_boxes, |node, ray| self.leaf(node, ray, sink));
            return;
        }
        let mut leaf =
            |node: &Bvh2Node, ray: &mut ObvhsRay, _: &mut RayHit| self.leaf(Some(node), ray, sink);
        let mut none = RayHit::none();
        fast_stack!(u32, (96, 192), self.bvh.max_depth, stack, {
            self.bvh.ray_traverse_dynamic(&mut stack, of_boxes, &mut none, &mut leaf);
        });
    }

    direct_batches!();

    fn stats(&self) -> StructureStats {
        let cells = self.bvh.nodes.iter().filter(|n| n.is_leaf()).count() as u64;
        let ids = self.bvh.primitive_indices.as_slice();
        StructureStats {
            inner_cells: self.bvh.nodes.len() as u64 - cells,
            cells,
            references: ids.len() as u64,
            bytes: (size_of_val(self.bvh.nodes.as_slice()) + size_of_val(ids)) as u64
                + self.direct.as_ref().map_or(0, DirectQueries::bytes),
            ..StructureStats::default()
        }
    }

    fn cells(&self, each: &mut CellVisitor<'_>) -> Result<(), NoCells> {
        let mut waiting = vec![(0, 0)];
        while let Some((number, depth)) = waiting.pop() {
            let node: &Bvh2Node = &self.bvh.nodes[number as usize];
            let b = node.aabb();
            let bounds = Aabb::<f64> { min: b.min.as_dvec3(), max: b.max.as_dvec3() };
            if node.is_leaf() {
                each(Cell::elementary(bounds, depth, leaf_ids(&self.bvh, node)));
            } else {
                let first = node.first_index;
                each(Cell::inner(bounds, depth));
                waiting.extend([(first + 1, depth + 1), (first, depth + 1)]);
            }
        }
        Ok(())
    }
}

impl<S: Scalar> ObvhsBvh2<S> {
    #[inline(always)]
    fn direct(&self) -> Option<&DirectQueries> {
        self.direct.as_ref()
    }

    /// Fits the boxes, and the library's copies of triangles, to primitives of which some stand
    /// elsewhere now. False where these would be kept in another way, and nothing was done.
    fn refit_all(&mut self, prims: &dyn Primitives<S>) -> bool {
        let triangles = direct::triangles(prims);
        if triangles.is_some() != self.direct.is_some() {
            return false;
        }
        let of = |id: &u32| match &triangles {
            Some(triangles) => triangles[*id as usize].aabb(),
            None => direct::rounded(&prims.bounds(*id)),
        };
        for leaf in 0..self.bvh.nodes.len() {
            if self.bvh.nodes[leaf].is_leaf() {
                let ids = leaf_ids(&self.bvh, &self.bvh.nodes[leaf]).iter();
                let bounds = ids.fold(ObvhsAabb::empty(), |all, id| all.union(&of(id)));
                self.bvh.nodes[leaf].set_aabb(bounds);
            }
        }
        self.bvh.refit_all();
        self.direct = triangles.map(|own| DirectQueries::new(prims, &self.bvh, &own));
        true
    }

    /// Tests a leaf's primitives (or reports an inner node, `None`); false ends the traversal.
    #[inline(always)]
    fn leaf<K: Sink<S>>(&self, node: Option<&Bvh2Node>, ray: &mut ObvhsRay, sink: &mut K) -> bool {
        let Some(node) = node else {
            sink.inner_step();
            return true;
        };
        sink.elementary_step(false);
        if sink.test(leaf_ids(&self.bvh, node)).is_break() {
            return false;
        }
        ray.tmax = sink.t_max().to_f64() as f32;
        true
    }
}

/// Primitives of a leaf.
#[inline(always)]
fn leaf_ids<'a>(bvh: &'a Bvh2, leaf: &Bvh2Node) -> &'a [u32] {
    &bvh.primitive_indices[leaf.first_index as usize..][..leaf.prim_count as usize]
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

/// Expected visits to nodes and tests of primitives of a ray that meets the scene (J. D. MacDonald,
/// K. S. Booth, "Heuristics for Ray Tracing Using Space Subdivision", The Visual Computer 6(3),
/// 1990), both costing the same.
fn expected_cost(bvh: &Bvh2) -> f64 {
    let area = |node: usize| f64::from(bvh.nodes[node].aabb().half_area());
    let weight = |node: usize| {
        if bvh.nodes[node].is_leaf() { f64::from(bvh.nodes[node].prim_count) } else { 1.0 }
    };
    let sum: f64 = (0..bvh.nodes.len()).map(|node| area(node) * weight(node)).sum();
    match bvh.nodes.first() {
        Some(_) if area(0) > 0.0 => sum / area(0),
        _ => 1.0,
    }
}
