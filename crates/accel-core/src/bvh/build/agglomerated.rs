//! The binary tree of one of obvhs's build presets, one box per leaf, in the steps of its own
//! `build_bvh2`, so that each scene gets one that its traversal can take.
//!
//! Papers: D. Meister, J. Bittner, "Parallel Locally-Ordered Clustering for Bounding Volume
//! Hierarchy Construction", TVCG 2018, and "Parallel Reinsertion for Bounding Volume Hierarchy
//! Optimization", 2018, as implemented by obvhs 0.4. The agglomeration joins pairs that choose each
//! other. Of boxes that lie one within the other only the innermost two do: so many passes are
//! needed as there are boxes, the build is quadratic, and the tree a list. Its traversals have
//! stacks for 96 levels (binary) and 32 (eight-wide), and lose what does not fit.
//!
//! Deviations, none of the library as its authors use it: where a sample of the boxes needs many
//! passes ([`is_nested`]), all are halved at the medians of their centres instead, before the
//! preset's other steps; subtrees that would reach below the levels a stack has room for are halved
//! likewise, as far down as there is room for it ([`limit_levels`]). Trees of other scenes are
//! obvhs's own, node by node.

use glam::DVec3;
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::bvh2::node::Bvh2Node;
use obvhs::bvh2::reinsertion::ReinsertionOptimizer;
use obvhs::bvh2::{Bvh2, DEFAULT_MAX_STACK_DEPTH};
use obvhs::ploc::PlocBuilder;
use obvhs::ploc::morton::morton_encode_u64_unorm;

/// Levels of a binary tree that obvhs's smallest stack has room for.
pub(crate) const LEVELS: u32 = DEFAULT_MAX_STACK_DEPTH as u32;

/// The preset of that name.
pub(crate) fn preset_named(name: &str) -> BvhBuildParams {
    use BvhBuildParams as B;
    match name {
        "fastest" => B::fastest_build(),
        "very-fast" => B::very_fast_build(),
        "fast" => B::fast_build(),
        "slow" => B::slow_build(),
        "very-slow" => B::very_slow_build(),
        _ => B::medium_build(),
    }
}

/// The binary tree of a preset before leaves are joined: one box per leaf.
pub(crate) fn reinserted(boxes: &[Aabb], params: &BvhBuildParams) -> Bvh2 {
    let mut bvh = agglomerated(boxes, params, true);
    ReinsertionOptimizer::default().run(&mut bvh, params.reinsertion_batch_ratio, None);
    bvh
}

/// A binary tree with one box per leaf; if `robust`, of at most [`LEVELS`] levels.
pub(crate) fn agglomerated(boxes: &[Aabb], params: &BvhBuildParams, robust: bool) -> Bvh2 {
    if robust && is_nested(boxes) {
        return halved(boxes);
    }
    let mut bvh = PlocBuilder::with_capacity(boxes.len()).build(
        params.ploc_search_distance,
        boxes,
        (0..boxes.len() as u32).collect(),
        params.sort_precision,
        params.search_depth_threshold,
    );
    // the number of passes, which no tree is deeper than
    if robust && bvh.max_depth > LEVELS as usize {
        limit_levels(&mut bvh, LEVELS);
    }
    bvh
}

/// Fewer boxes are agglomerated in little time whatever they are.
const FEW: usize = 8192;
/// One box of this many is sampled, but at least [`FEWEST_SEEN`]: about 1% of the work of the
/// fastest preset.
const SAMPLED: usize = 64;
const FEWEST_SEEN: usize = 512;
/// Passes that a sample of boxes that are not nested stays well below: about 20 are needed. Boxes
/// in one another that are too few to be seen, up to 4,096 or an eighth of all, cost little.
const PASSES: usize = 64;

/// Returns whether agglomeration would take time in proportion to the square of the number of
/// boxes: a regular sample of them, agglomerated with a search distance of 1, needs many passes.
fn is_nested(boxes: &[Aabb]) -> bool {
    if boxes.len() <= FEW {
        return false;
    }
    let stride = SAMPLED.min(boxes.len() / FEWEST_SEEN);
    let sample = || boxes.iter().step_by(stride);
    let all = sample().fold(Aabb::empty(), |all, b| all.union(b));
    let scale = 1.0 / all.diagonal().as_dvec3().max(DVec3::splat(f64::MIN_POSITIVE));
    let place = |b: &Aabb| (b.center().as_dvec3() - all.min.as_dvec3()) * scale;
    let mut in_order: Vec<_> = sample().map(|b| (morton_encode_u64_unorm(place(b)), *b)).collect();
    in_order.sort_by_key(|(key, _)| *key);
    let mut current: Vec<Aabb> = in_order.into_iter().map(|(_, b)| b).collect();
    let mut next = Vec::new();
    for _ in 0..PASSES {
        if current.len() == 1 {
            return false;
        }
        let joined = |i: usize| current[i].union(&current[i + 1]).half_area();
        // whether box i chooses the one behind it
        let last = current.len() - 1;
        let looks_on = |i: usize| i < last && (i == 0 || joined(i) <= joined(i - 1));
        let mut i = 0;
        while i <= last {
            if looks_on(i) && !looks_on(i + 1) {
                next.push(current[i].union(&current[i + 1]));
                i += 2;
            } else {
                next.push(current[i]);
                i += 1;
            }
        }
        std::mem::swap(&mut current, &mut next);
        next.clear();
    }
    current.len() > 1
}

/// A balanced tree with one box per leaf.
fn halved(boxes: &[Aabb]) -> Bvh2 {
    let mut bvh = Bvh2::default();
    bvh.reset_for_reuse(boxes.len(), Some((0..boxes.len() as u32).collect()));
    let leaf = |(b, i): (&Aabb, u32)| Bvh2Node::new(*b, 1, i);
    let mut leaves: Vec<Bvh2Node> = boxes.iter().zip(0..).map(leaf).collect();
    let mut pairs = (1..boxes.len() as u32).map(|i| 2 * i - 1);
    halve(&mut bvh.nodes, 0, &mut leaves, &mut pairs);
    bvh
}

/// Makes node `at` the root of a balanced tree over the leaves; inner nodes have their children at
/// the next of `pairs`.
fn halve(
    nodes: &mut [Bvh2Node],
    at: usize,
    leaves: &mut [Bvh2Node],
    pairs: &mut impl Iterator<Item = u32>,
) {
    if let [leaf] = leaves {
        nodes[at] = *leaf;
        return;
    }
    let Some(pair) = pairs.next() else { return };
    let all = leaves.iter().fold(Aabb::empty(), |all, leaf| all.union(leaf.aabb()));
    let centres = leaves.iter().fold(Aabb::empty(), |mut centres, leaf| {
        centres.extend(leaf.aabb().center());
        centres
    });
    let axis = centres.largest_axis();
    let middle = leaves.len() / 2;
    // of boxes with one centre the inner ones; of equal ones in the order of their items
    leaves.select_nth_unstable_by(middle, |a, b| {
        let by_centre = a.aabb().center()[axis].total_cmp(&b.aabb().center()[axis]);
        by_centre
            .then_with(|| a.aabb().half_area().total_cmp(&b.aabb().half_area()))
            .then_with(|| a.first_index.cmp(&b.first_index))
    });
    nodes[at] = Bvh2Node::new(all, 0, pair);
    let (lower, upper) = leaves.split_at_mut(middle);
    halve(nodes, pair as usize, lower, pairs);
    halve(nodes, pair as usize + 1, upper, pairs);
}

/// Summary of a subtree, its root included.
#[derive(Debug, Clone, Copy)]
struct SubtreeSummary {
    levels: u32,
    leaves: u32,
}

impl SubtreeSummary {
    /// Levels of a balanced tree over the same leaves.
    fn least_levels(self) -> u32 {
        1 + self.leaves.next_power_of_two().ilog2()
    }
}

/// Summarises the subtree of each node.
fn below(bvh: &Bvh2) -> Vec<SubtreeSummary> {
    let mut order = Vec::with_capacity(bvh.nodes.len());
    let mut waiting = if bvh.nodes.is_empty() { vec![] } else { vec![0] };
    while let Some(at) = waiting.pop() {
        order.push(at);
        let node = &bvh.nodes[at as usize];
        if !node.is_leaf() {
            waiting.extend([node.first_index, node.first_index + 1]);
        }
    }
    let mut all = vec![SubtreeSummary { levels: 1, leaves: 1 }; bvh.nodes.len()];
    for at in order.into_iter().rev() {
        let node = &bvh.nodes[at as usize];
        if !node.is_leaf() {
            let first = node.first_index as usize;
            let (a, b) = (all[first], all[first + 1]);
            let levels = 1 + a.levels.max(b.levels);
            all[at as usize] = SubtreeSummary { levels, leaves: a.leaves + b.leaves };
        }
    }
    all
}

/// Levels of nodes, leaves included.
pub(crate) fn levels(bvh: &Bvh2) -> u32 {
    below(bvh).first().map_or(0, |root| root.levels)
}

/// Halves the subtrees that reach below `limit` levels, each as far down as there is room for a
/// balanced one. More than 2^(limit - 1) leaves cannot be served, and make a balanced tree.
pub(crate) fn limit_levels(bvh: &mut Bvh2, limit: u32) {
    let all = below(bvh);
    bvh.max_depth = DEFAULT_MAX_STACK_DEPTH;
    if all.first().is_none_or(|root| root.levels <= limit) {
        return;
    }
    let mut waiting = vec![(0u32, limit)];
    while let Some((at, room)) = waiting.pop() {
        if all[at as usize].levels <= room {
            continue;
        }
        let first = bvh.nodes[at as usize].first_index;
        let below = room.saturating_sub(1);
        if [first, first + 1].iter().all(|child| all[*child as usize].least_levels() <= below) {
            waiting.extend([(first, below), (first + 1, below)]);
        } else {
            halve_subtree(bvh, at);
        }
    }
    // both follow from the nodes, and are made again where they are needed
    bvh.parents.clear();
    bvh.primitives_to_nodes.clear();
    bvh.children_are_ordered_after_parents = false;
}

/// Makes what is below a node a balanced tree, in the places that it has.
fn halve_subtree(bvh: &mut Bvh2, root: u32) {
    let (mut leaves, mut pairs) = (Vec::new(), Vec::new());
    let mut waiting = vec![root];
    while let Some(at) = waiting.pop() {
        let node = bvh.nodes[at as usize];
        if node.is_leaf() {
            leaves.push(node);
        } else {
            pairs.push(node.first_index);
            waiting.extend([node.first_index, node.first_index + 1]);
        }
    }
    pairs.sort_unstable();
    halve(&mut bvh.nodes, root as usize, &mut leaves, &mut pairs.into_iter());
}

#[cfg(test)]
pub(crate) mod tests {
    use glam::Vec3A;

    use super::*;

    /// Checks a tree over `boxes`: each box in one leaf, leaves within their ancestors, at most
    /// `limit` levels. Returns the fault.
    pub(crate) fn fault(bvh: &Bvh2, boxes: &[Aabb], limit: u32) -> Option<String> {
        let mut seen = vec![0; boxes.len()];
        let mut waiting = vec![(0u32, 1, Vec3A::NEG_INFINITY, Vec3A::INFINITY)];
        while let Some((at, level, lo, hi)) = waiting.pop() {
            let node = &bvh.nodes[at as usize];
            let b = node.aabb();
            if level > limit {
                return Some(format!("level {level}"));
            }
            if b.min.cmplt(lo).any() || b.max.cmpgt(hi).any() {
                return Some(format!("node {at} reaches out of its parent"));
            }
            if node.is_leaf() {
                for i in node.first_index..node.first_index + node.prim_count {
                    let id = bvh.primitive_indices[i as usize] as usize;
                    seen[id] += 1;
                    if boxes[id].min.cmplt(b.min).any() || boxes[id].max.cmpgt(b.max).any() {
                        return Some(format!("box {id} reaches out of its leaf"));
                    }
                }
            } else {
                for child in [node.first_index, node.first_index + 1] {
                    waiting.push((child, level + 1, b.min, b.max));
                }
            }
        }
        seen.iter().position(|n| *n != 1).map(|id| format!("box {id} is {} times", seen[id]))
    }

    pub(crate) fn nested(n: usize) -> Vec<Aabb> {
        let side = |i: usize| Vec3A::splat(1.0 + i as f32 / n as f32);
        (0..n).map(|i| Aabb::new(Vec3A::ZERO, side(i))).collect()
    }

    /// Boxes of the size given at places without order.
    pub(crate) fn scattered(n: usize, size: f32) -> Vec<Aabb> {
        let part = |i: usize, by: f64| (i as f64 * by).fract() as f32;
        let at = |i| Vec3A::new(part(i, 0.754_877), part(i, 0.569_84), part(i, 0.438_28));
        (0..n).map(|i| Aabb::new(at(i), at(i) + size)).collect()
    }

    const SOME_PRESETS: [BvhBuildParams; 3] = [
        BvhBuildParams::fastest_build(),
        BvhBuildParams::medium_build(),
        BvhBuildParams::very_slow_build(),
    ];

    #[test]
    fn nested_boxes_are_seen_and_no_others() {
        assert!(is_nested(&nested(9000)) && !is_nested(&nested(FEW)));
        for size in [0.0, 0.001, 0.1, 3.0] {
            for n in [9000, 100_000] {
                assert!(!is_nested(&scattered(n, size)), "{n} {size}");
            }
        }
        // a part of the boxes, beside others
        for (n, others) in [(4000, 16_000), (8000, 200_000)] {
            let mut some = scattered(others, 0.01);
            some.extend(nested(n));
            assert!(is_nested(&some), "{n} of {}", some.len());
        }
    }

    #[test]
    fn trees_are_whole_and_no_deeper_than_their_stacks() {
        for boxes in [nested(1), nested(2), nested(3), nested(1500), nested(9000)] {
            for params in &SOME_PRESETS {
                let mut bvh = reinserted(&boxes, params);
                limit_levels(&mut bvh, LEVELS);
                assert_eq!(fault(&bvh, &boxes, LEVELS), None);
            }
        }
    }

    #[test]
    fn only_what_is_too_deep_changes() {
        let boxes = nested(1500);
        let [params, ..] = &SOME_PRESETS;
        let list = agglomerated(&boxes, params, false);
        assert_eq!(levels(&list), 1500);
        let mut limited = list.clone();
        limit_levels(&mut limited, 1500);
        assert!(limited.nodes.iter().zip(&list.nodes).all(|(a, b)| a.aabb() == b.aabb()));
        for limit in [11 + 1, 13, 31, 96, 700] {
            let mut limited = list.clone();
            limit_levels(&mut limited, limit);
            assert_eq!(fault(&limited, &boxes, limit), None);
            // a list of 1500 begins as it was
            let kept = limited.nodes.iter().zip(&list.nodes).filter(|(a, b)| a.aabb() == b.aabb());
            assert!(kept.count() as u32 >= limit.saturating_sub(12), "{limit}");
        }
        // balanced, and still one level too many
        let mut limited = list.clone();
        limit_levels(&mut limited, 11);
        assert_eq!(fault(&limited, &boxes, 12), None);
    }

    #[test]
    fn broken_trees_are_seen() {
        // planted faults
        let boxes = scattered(300, 0.02);
        let right = reinserted(&boxes, &SOME_PRESETS[0]);
        assert_eq!(fault(&right, &boxes, LEVELS), None);
        assert!(fault(&right, &boxes, 5).unwrap().starts_with("level"));
        let leaf = right.nodes.iter().position(Bvh2Node::is_leaf).unwrap();
        let mut lost = right.clone();
        lost.nodes[leaf].first_index = (lost.nodes[leaf].first_index + 1) % 300;
        assert!(fault(&lost, &boxes, LEVELS).is_some());
        let mut small = right.clone();
        small.nodes[1].set_aabb(Aabb::new(Vec3A::ZERO, Vec3A::ZERO));
        assert!(fault(&small, &boxes, LEVELS).is_some());
    }
}
