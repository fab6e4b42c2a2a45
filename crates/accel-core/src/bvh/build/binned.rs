//! A binary tree built from the top down: a set of boxes is divided where the surface-area
//! heuristic, looked at in equal bins of their centres, says that it costs least; then its upper
//! nodes are inserted anew where they cost less.
//!
//! Papers: I. Wald, "On Fast Construction of SAH-based Bounding Volume Hierarchies", RT 2007
//! (bins); D. Meister, J. Bittner, "Parallel Reinsertion for Bounding Volume Hierarchy
//! Optimization", Computer Graphics Forum 37(2), 2018, as implemented by obvhs. Deviations: all
//! three axes are binned; a side costs what its blocks of triangles cost; few boxes have few bins,
//! the fewest none; nodes of few boxes are not inserted anew.

use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::reinsertion::ReinsertionOptimizer;

use super::boxes::{Item, SetBounds};
use super::sets::{Nodes, Set, Sizes, larger_than};
use crate::parallel;

/// So few boxes are not divided: they mostly share a block.
const FEW: u32 = 3;

/// Nodes of more boxes than this are inserted anew.
pub(super) const MANY: usize = 64;
/// So are those of more boxes than this, as long as it pays: mostly where large triangles are among
/// small ones (*kitchen*: a ray visits 11 to 13% fewer nodes).
const SOME: usize = 8;
/// The part of their area that nodes must lose in a round, or no other follows.
const LEAST_GAIN: f64 = 0.001;
/// The same where all of them were inserted anew.
const GAIN_OF_ALL: f64 = 0.15;

/// The tree over these boxes, so many in a leaf at most; the same for any number of threads.
pub(crate) fn tree(boxes: &[Aabb], longest_leaf: u32) -> Bvh2 {
    let (mut bvh, nodes) = divided(boxes, longest_leaf, 1);
    insert_upper_anew(&mut bvh, &mut larger_than(&nodes, MANY));
    let rounds = [256, 128, 64, 32, 16, 8, 4, 2].map(|part| (part, GAIN_OF_ALL / part as f64));
    insert_anew(&mut bvh, &mut larger_than(&nodes, SOME), rounds);
    bvh
}

/// The tree whose root is on this level, and its nodes of some boxes or more, and of how many.
fn divided(boxes: &[Aabb], longest_leaf: u32, level: u32) -> (Bvh2, Vec<(u32, u32)>) {
    let item = |i: usize| Item::of(&boxes[i], i as u32);
    let mut items: Vec<Item> = parallel::collect(boxes.len(), item);
    if items.is_empty() {
        return (Bvh2::default(), Vec::new());
    }
    let around = SetBounds::of_all(&items);
    let set = Set { items: &mut items, first: 0, around, level, node: 0 };
    let few = FEW.min(longest_leaf) as usize;
    let sizes = Sizes { few, upper_above: SOME, is_parallel: true };
    let Nodes { all, upper } = set.tree(sizes);
    let primitive_indices = parallel::collect(items.len(), |place| items[place].number());
    (Bvh2 { nodes: all, primitive_indices, ..Bvh2::default() }, upper)
}

/// Inserts the largest of these nodes anew, half of them, then fewer and fewer, as obvhs does.
pub(super) fn insert_upper_anew(bvh: &mut Bvh2, nodes: &mut [u32]) {
    insert_anew(bvh, nodes, (2..64).step_by(4).map(|part| (part, LEAST_GAIN)));
}

/// Inserts the largest of these nodes anew, in each round one of so many, until all of them lose less
/// than this part of their area in it.
fn insert_anew(bvh: &mut Bvh2, nodes: &mut [u32], rounds: impl IntoIterator<Item = (usize, f64)>) {
    // in which order they come depends on the number of threads, and so would their sum
    parallel::sort(nodes);
    let mut reinsertion = ReinsertionOptimizer::default();
    // after the round before; none before the first
    let mut most_area = f64::INFINITY;
    for (part, least_gain) in rounds {
        let most = nodes.len() / part;
        if most == 0 {
            return;
        }
        // areas are not negative: their bits are in their order
        let key = |i: usize| {
            let node = nodes[i];
            let area = bvh.nodes[node as usize].aabb().half_area();
            u64::from(!area.to_bits()) << 32 | u64::from(node)
        };
        let mut by_area = parallel::collect(nodes.len(), key);
        let area_of = |key: &u64| f64::from(f32::from_bits(!(key >> 32) as u32));
        let area: f64 = by_area.iter().map(area_of).sum();
        if area > most_area {
            return;
        }
        most_area = (1.0 - least_gain) * area;
        by_area.select_nth_unstable(most - 1);
        by_area[..most].sort_unstable();
        let largest: Vec<u32> = by_area[..most].iter().map(|&key| key as u32).collect();
        reinsertion.run_with_candidates(bvh, &largest, 1);
    }
}

#[cfg(test)]
pub(super) mod tests {
    use obvhs::bvh2::node::Bvh2Node;

    use super::super::cut::{BinSplit, Bins};
    use super::super::sets::MOST_CUTS;
    use super::*;
    use crate::bvh::build::agglomerated::tests::{fault, nested, scattered};

    /// Asserts that trees have each box once, have few levels and do not depend on the number of
    /// threads.
    pub fn assert_whole_and_the_same(tree: fn(&[Aabb], u32) -> Bvh2) {
        let built = |boxes: &[Aabb], threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| tree(boxes, 16))
        };
        let mut alike = scattered(3000, 0.01);
        let first = alike[0];
        alike[500..2500].fill(first);
        for boxes in [nested(1), nested(2), nested(5), nested(9000), scattered(30_000, 0.02), alike]
        {
            let one = built(&boxes, 1);
            assert_eq!(fault(&one, &boxes, 96), None, "{} boxes", boxes.len());
            for threads in [2, 5] {
                let other = built(&boxes, threads);
                assert!(other.primitive_indices == one.primitive_indices);
                assert_eq!(other.nodes.len(), one.nodes.len());
                let same = |(a, b): (&Bvh2Node, &Bvh2Node)| {
                    a.aabb() == b.aabb() && a.first_index == b.first_index
                };
                assert!(other.nodes.iter().zip(&one.nodes).all(same), "{threads} threads");
            }
        }
        assert!(tree(&[], 16).nodes.is_empty());
    }

    /// Asserts that leaves have at most this many boxes, and no more than is asked for.
    pub fn assert_few_in_a_leaf(tree: fn(&[Aabb], u32) -> Bvh2, few: u32) {
        let boxes = scattered(3000, 0.01);
        for longest in [1, 2, 3, 5, 16] {
            let bvh = tree(&boxes, longest);
            assert_eq!(fault(&bvh, &boxes, 96), None);
            let (mut most, mut waiting) = (0, vec![0]);
            while let Some(at) = waiting.pop() {
                let node: &Bvh2Node = &bvh.nodes[at as usize];
                most = most.max(node.prim_count);
                if !node.is_leaf() {
                    waiting.extend([node.first_index, node.first_index + 1]);
                }
            }
            assert_eq!(most, few.min(longest));
        }
    }

    #[test]
    fn trees_are_whole_and_the_same_for_any_number_of_threads() {
        assert_whole_and_the_same(tree);
    }

    #[test]
    fn leaves_have_a_few_boxes_and_no_more_than_is_asked_for() {
        assert_few_in_a_leaf(tree, FEW);
    }

    #[test]
    fn nodes_are_inserted_anew_as_long_as_it_pays() {
        let mut boxes = scattered(20_000, 0.001);
        boxes.iter_mut().step_by(7).for_each(|aabb| aabb.max += 0.1);
        let after = |rounds: &[(usize, f64)]| {
            let (mut bvh, nodes) = divided(&boxes, 3, 1);
            insert_anew(&mut bvh, &mut larger_than(&nodes, SOME), rounds.iter().copied());
            assert_eq!(fault(&bvh, &boxes, 96), None);
            bvh.nodes.iter().map(|n| n.aabb().half_area()).sum::<f32>()
        };
        let (none, one, two) = (after(&[]), after(&[(2, 0.0)]), after(&[(2, 0.0); 2]));
        assert!(two < one && one < none, "{two} {one} {none}");
        // no other round where one must gain everything
        assert_eq!(after(&[(2, 1.0), (2, 0.0)]), one);
    }

    #[test]
    fn what_is_deep_is_balanced() {
        let boxes = scattered(1000, 0.01);
        let levels = |level| {
            (9..96).find(|most| fault(&divided(&boxes, 3, level).0, &boxes, *most).is_none())
        };
        assert_eq!(levels(MOST_CUTS + 1), Some(10));
        assert!(levels(1) > Some(10), "{:?}", levels(1));
    }

    /// Two clusters far from each other.
    #[test]
    fn the_first_cut_is_where_it_costs_least() {
        let mut boxes = scattered(600, 0.01);
        for aabb in &mut boxes[400..] {
            *aabb = Aabb::new(aabb.min + 5.0, aabb.max + 5.0);
        }
        let mut items: Vec<Item> = boxes.iter().zip(0..).map(|(b, i)| Item::of(b, i)).collect();
        let around = SetBounds::of(&items);
        let of = |items: &[Item], around: &SetBounds| {
            BinSplit::of(items, &around.centres, &mut { Bins::NONE })
        };
        let cut = of(&items, &around).unwrap();
        let (middle, [lower, upper]) = cut.partition(&mut items);
        assert_eq!(middle, 400);
        let numbers: Vec<u32> = items.iter().map(Item::number).collect();
        assert!(
            numbers[..400].iter().all(|i| *i < 400) && numbers[400..].iter().all(|i| *i >= 400)
        );
        assert!(
            lower.items.aabb().max.max_element() < 1.1
                && upper.items.aabb().min.min_element() > 4.9
        );
        assert!(of(&items[..1], &SetBounds::of(&items[..1])).is_none());
    }
}
