//! The trees of obvhs: over its own triangles as `build_bvh2_from_tris` and `build_cwbvh_from_tris`
//! make them, presplitting included; over boxes of other primitives as `build_bvh2` and
//! `build_cwbvh` do.
//!
//! These functions are not called but their steps taken, for one reason: their conversion to
//! eight-wide trees recurses, and ends the process where a binary tree is a list. So its levels are
//! looked at between the steps where they can be too many, and those of the tree that came of it,
//! which obvhs's stack has no room for and its traversal does not check: [`DepthError`]. A binary
//! tree whose stack is on the heap is told its true depth, as it would panic. The trees are equal,
//! node by node; only `adapter=robust` halves what is too deep.

use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::leaf_collapser::collapse;
use obvhs::bvh2::reinsertion::ReinsertionOptimizer;
use obvhs::cwbvh::CwBvh;
use obvhs::cwbvh::bvh2_to_cwbvh::bvh2_to_cwbvh;
use obvhs::ploc::PlocBuilder;
use obvhs::splits::split_aabbs_preset;
use obvhs::triangle::Triangle;
use obvhs::{Boundable, BvhBuildParams};

use crate::bvh::build::agglomerated::{LEVELS, levels, limit_levels};

/// Levels of an eight-wide tree: obvhs's stack holds one entry per level and is not checked by it.
pub(crate) const WIDE_LEVELS: u32 = 31;

/// Levels of a binary tree up to which its conversion, which is recursive, is let run.
const CONVERTED_LEVELS: u32 = 4096;

/// Why a tree cannot be had: so many levels in place of so many.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct DepthError {
    pub(crate) needed: u32,
    pub(crate) limit: u32,
}

/// The other steps of `build_bvh2` and `build_bvh2_from_tris`.
pub(crate) fn binary(mut bvh: Bvh2, params: &BvhBuildParams) -> Bvh2 {
    let mut reinsertion = ReinsertionOptimizer::default();
    reinsertion.run(&mut bvh, params.reinsertion_batch_ratio, None);
    collapse(&mut bvh, params.max_prims_per_leaf.clamp(1, 255), params.collapse_traversal_cost);
    let again = params.post_collapse_reinsertion_batch_ratio_multiplier;
    reinsertion.run(&mut bvh, params.reinsertion_batch_ratio * again, None);
    if bvh.max_depth > LEVELS as usize {
        // a stack of so many entries, on the heap, panics when it is full
        bvh.max_depth = bvh.max_depth.max(levels(&bvh) as usize);
    }
    bvh
}

/// The other steps of `build_cwbvh` and `build_cwbvh_from_tris`; if `robust`, trees that are too
/// deep are repaired.
///
/// # Errors
/// [`DepthError`]; none is known that the repairs do not serve.
pub(crate) fn eight_wide(
    mut bvh: Bvh2,
    params: &BvhBuildParams,
    robust: bool,
) -> Result<CwBvh, DepthError> {
    ReinsertionOptimizer::default().run(&mut bvh, params.reinsertion_batch_ratio, None);
    let binary_levels = if bvh.max_depth > LEVELS as usize { levels(&bvh) } else { 0 };
    if binary_levels > CONVERTED_LEVELS {
        return Err(DepthError { needed: binary_levels, limit: CONVERTED_LEVELS });
    }
    let leaf = params.max_prims_per_leaf.clamp(1, 3);
    let mut wide = bvh2_to_cwbvh(&bvh, leaf, true, false);
    // a wide tree has no more levels than the binary one that it is made of, and mostly a third
    for limit in [2 * WIDE_LEVELS, WIDE_LEVELS] {
        if !robust || wide_levels(&wide) <= WIDE_LEVELS {
            break;
        }
        limit_levels(&mut bvh, limit);
        wide = bvh2_to_cwbvh(&bvh, leaf, true, false);
    }
    match wide_levels(&wide) {
        needed if needed > WIDE_LEVELS => Err(DepthError { needed, limit: WIDE_LEVELS }),
        _ => Ok(wide),
    }
}

/// Levels of nodes of an eight-wide tree.
fn wide_levels(bvh: &CwBvh) -> u32 {
    let mut deepest = 0;
    let mut waiting = if bvh.nodes.is_empty() { vec![] } else { vec![(0u32, 1u32)] };
    while let Some((i, level)) = waiting.pop() {
        deepest = deepest.max(level);
        let node = &bvh.nodes[i as usize];
        waiting.extend((0..node.imask.count_ones()).map(|c| (node.child_base_idx + c, level + 1)));
    }
    deepest
}

/// A binary tree with one box per leaf, that of a triangle, or of a part of it: the first step of
/// `build_bvh2_from_tris` and `build_cwbvh_from_tris`, as [`agglomerated`] is of `build_bvh2` and
/// `build_cwbvh`.
pub(crate) fn agglomerated_triangles(triangles: &[Triangle], params: &BvhBuildParams) -> Bvh2 {
    fn build<T: Boundable>(leaves: &[T], ids: Vec<u32>, params: &BvhBuildParams) -> Bvh2 {
        PlocBuilder::with_capacity(leaves.len()).build(
            params.ploc_search_distance,
            leaves,
            ids,
            params.sort_precision,
            params.search_depth_threshold,
        )
    }
    let ids = (0..triangles.len() as u32).collect();
    let mut bvh = if params.pre_split {
        let (boxes, ids) = split(triangles, ids);
        build(&boxes, ids, params)
    } else {
        build(triangles, ids, params)
    };
    bvh.uses_spatial_splits = params.pre_split;
    bvh
}

/// The boxes of all triangles, those of large ones in parts, and whose each is.
fn split(triangles: &[Triangle], mut ids: Vec<u32>) -> (Vec<Aabb>, Vec<u32>) {
    let mut boxes: Vec<Aabb> = triangles.iter().map(Triangle::aabb).collect();
    let (mut sum, mut largest) = (0.0, 0.0f32);
    for area in boxes.iter().map(Aabb::half_area) {
        largest = area.max(largest);
        sum += area;
    }
    let average = sum / triangles.len() as f32;
    split_aabbs_preset(&mut boxes, &mut ids, triangles, average, largest);
    (boxes, ids)
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use glam::Vec3A;
    use obvhs::bvh2::builder::{build_bvh2, build_bvh2_from_tris};
    use obvhs::bvh2::node::Bvh2Node;
    use obvhs::cwbvh::builder::{build_cwbvh, build_cwbvh_from_tris};

    use super::*;
    use crate::bvh::build::PRESETS;
    use crate::bvh::build::agglomerated::tests::{nested, scattered as boxes_scattered};
    use crate::bvh::build::agglomerated::{agglomerated, preset_named};

    /// Triangles at places without order, every tenth large.
    fn scattered(n: usize) -> Vec<Triangle> {
        let part = |i: usize, by: f64| (i as f64 * by).fract() as f32;
        let at = |i| Vec3A::new(part(i, 0.754_877), part(i, 0.569_84), part(i, 0.438_28));
        let triangle = |i: usize| {
            let (v0, size) = (at(3 * i), if i.is_multiple_of(10) { 0.5 } else { 0.02 });
            Triangle { v0, v1: v0 + at(3 * i + 1) * size, v2: v0 + at(3 * i + 2) * size }
        };
        (0..n).map(triangle).collect()
    }

    fn presets() -> impl Iterator<Item = (&'static str, BvhBuildParams)> {
        PRESETS.iter().map(|preset| (*preset, preset_named(preset)))
    }

    fn equal(a: &Bvh2, b: &Bvh2) -> bool {
        let same = |(a, b): (&Bvh2Node, &Bvh2Node)| {
            a.aabb() == b.aabb() && a.first_index == b.first_index && a.prim_count == b.prim_count
        };
        a.primitive_indices == b.primitive_indices
            && a.max_depth == b.max_depth
            && a.nodes.len() == b.nodes.len()
            && a.nodes.iter().zip(&b.nodes).all(same)
    }

    #[test]
    fn trees_are_those_of_obvhs() {
        let mut split = 0;
        for n in [1, 2, 5, 6000] {
            let triangles = scattered(n);
            for (preset, params) in presets() {
                let time = &mut Duration::default();
                let theirs = build_bvh2_from_tris(&triangles, params, time);
                let ours = binary(agglomerated_triangles(&triangles, &params), &params);
                assert!(equal(&ours, &theirs), "{n} {preset}");
                split += usize::from(theirs.primitive_indices.len() > n);
                let theirs = build_cwbvh_from_tris(&triangles, params, time);
                let ours = agglomerated_triangles(&triangles, &params);
                assert!(eight_wide(ours, &params, false).unwrap() == theirs, "{n} {preset}");
            }
        }
        assert_eq!(split, 2, "the two slow presets split");
    }

    #[test]
    fn trees_of_boxes_are_those_of_obvhs() {
        let boxes = boxes_scattered(9000, 0.02);
        for (preset, params) in presets() {
            let time = &mut Duration::default();
            let theirs = build_bvh2(&boxes, params, time);
            let ours = |robust| agglomerated(&boxes, &params, robust);
            assert!(equal(&binary(ours(false), &params), &theirs), "{preset}");
            let theirs = build_cwbvh(&boxes, params, time);
            for robust in [false, true] {
                let ours = eight_wide(ours(robust), &params, robust);
                assert!(ours.unwrap() == theirs, "{preset}");
            }
        }
    }

    #[test]
    fn nested_boxes_are_refused_or_halved() {
        let fastest = BvhBuildParams::fastest_build();
        for (n, limit) in [(1500, WIDE_LEVELS), (4200, CONVERTED_LEVELS)] {
            let boxes = nested(n);
            let tree = agglomerated(&boxes, &fastest, false);
            let refused = eight_wide(tree, &fastest, false).unwrap_err();
            assert!(refused.limit == limit && refused.needed > limit, "{refused:?}");
            for (_, params) in presets() {
                let tree = agglomerated(&boxes, &params, true);
                let wide = eight_wide(tree, &params, true).unwrap();
                assert!(wide_levels(&wide) <= WIDE_LEVELS);
                let mut ids = wide.primitive_indices.clone();
                ids.sort_unstable();
                assert!(ids.iter().copied().eq(0..n as u32));
            }
        }
    }

    #[test]
    fn another_tree_is_seen() {
        // planted fault: the boxes without presplitting, and one node moved
        let triangles = scattered(6000);
        let (_, slow) = presets().find(|(preset, _)| *preset == "slow").unwrap();
        let theirs = build_bvh2_from_tris(&triangles, slow, &mut Duration::default());
        let unsplit = BvhBuildParams { pre_split: false, ..slow };
        let ours = binary(agglomerated_triangles(&triangles, &unsplit), &unsplit);
        assert!(!equal(&ours, &theirs));
        let mut moved = theirs.clone();
        moved.nodes[7].set_aabb(Aabb::new(Vec3A::ZERO, Vec3A::ZERO));
        assert!(equal(&theirs, &theirs) && !equal(&moved, &theirs));
    }

    #[test]
    fn what_would_end_the_process_is_refused() {
        // triangles in one another, whose tree is a list
        let corner = |i: usize| 1.0 + i as f32 / 6000.0;
        let nested = |i| Triangle {
            v0: Vec3A::ZERO,
            v1: Vec3A::X * corner(i),
            v2: (Vec3A::Y + Vec3A::Z) * corner(i),
        };
        let triangles: Vec<_> = (0..6000).map(nested).collect();
        let fastest = BvhBuildParams::fastest_build();
        let tree = |n: usize| agglomerated_triangles(&triangles[..n], &fastest);
        let refused = eight_wide(tree(6000), &fastest, false).unwrap_err();
        assert!(refused.needed > refused.limit && refused.limit > WIDE_LEVELS, "{refused:?}");
        let refused = eight_wide(tree(1500), &fastest, false).unwrap_err();
        assert_eq!(refused.limit, WIDE_LEVELS);
        assert_eq!(binary(tree(6000), &fastest).nodes.len(), 2 * 6000 - 1);
    }
}
