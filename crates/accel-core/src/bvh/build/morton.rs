//! A binary tree over clusters of boxes that lie next to each other in Morton order, and one within
//! each cluster, all binned: built in half the time of one that is binned over all boxes.
//!
//! Papers: J. Pantaleoni, D. Luebke, "HLBVH: Hierarchical LBVH Construction for Real-Time Ray
//! Tracing", HPG 2010, and K. Garanzha, J. Pantaleoni, D. McAllister, "Simpler and Faster HLBVH
//! with Work Queues", HPG 2011 (clusters by the bits that codes begin with, a tree by the
//! surface-area heuristic above them). Deviations: within a cluster the tree is binned as well; a
//! box that is large in its cluster is none of it.

use std::ops::Range;

use glam::Vec3A;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::node::Bvh2Node;
use obvhs::ploc::morton::morton_encode_u64;
use rayon::prelude::*;

use super::binned::{MANY, insert_upper_anew};
use super::boxes::{Item, SetBounds};
use super::cut::Bins;
use super::sets::{MOST_CUTS, Nodes, Set, Sizes, larger_than};
use crate::counting_sort::{DIGIT_BITS, by_two_digits};
use crate::memory::prefetch;
use crate::parallel;
use crate::primitives::TriangleBlock;

/// A cluster has no more boxes than this, unless their codes are the same.
const MOST: usize = 32;

/// So many boxes are not divided: they share a block.
const FEW: u32 = TriangleBlock::<f32>::LANES as u32;

/// Nodes of more clusters than this are inserted anew.
const MANY_CLUSTERS: usize = 4;

/// Levels within a cluster, of the [`MOST_CUTS`] of a tree, below which its sets are halved.
const LEVELS: u32 = 12;

/// A box is asked for so many places before its turn.
const AHEAD: usize = 16;

/// The tree over these boxes, so many in a leaf at most; the same for any number of threads.
pub(crate) fn tree(boxes: &[Aabb], longest_leaf: u32) -> Bvh2 {
    if boxes.is_empty() {
        return Bvh2::default();
    }
    let keys = Keys::of(boxes);
    let item = |place: usize| {
        prefetch(&boxes[keys.number((place + AHEAD).min(boxes.len() - 1)) as usize]);
        let number = keys.number(place);
        Item::of(&boxes[number as usize], number)
    };
    let mut items: Vec<Item> = parallel::collect(boxes.len(), item);
    let clusters = clusters(&keys.all_runs(), &mut items);
    drop(keys);
    let head = |number: usize| clusters[number].head(number as u32);
    let mut heads: Vec<Item> = parallel::collect(clusters.len(), head);
    let around = SetBounds::of_all(&heads);
    let set = Set { items: &mut heads, first: 0, around, level: 1 + LEVELS, node: 0 };
    let sizes = Sizes { few: 1, upper_above: MANY_CLUSTERS, is_parallel: true };
    let nodes = set.tree(sizes);
    let nodes = within(nodes, &heads, &clusters, &mut items, FEW.min(longest_leaf) as usize);
    let primitive_indices = parallel::collect(items.len(), |place| items[place].number());
    let mut bvh = Bvh2 { nodes: nodes.all, primitive_indices, ..Bvh2::default() };
    insert_upper_anew(&mut bvh, &mut larger_than(&nodes.upper, 0));
    bvh
}

/// Codes and numbers of boxes in Morton order of their centres: a code in the upper bits of each,
/// then a number.
struct Keys {
    keys: Vec<u64>,
    number_bits: u32,
}

impl Keys {
    fn of(boxes: &[Aabb]) -> Self {
        let number_bits = usize::BITS - (boxes.len() - 1).leading_zeros();
        let axis_bits = ((u64::BITS - number_bits) / 3).min(21);
        let centre = |number: usize| boxes[number].min + boxes[number].max;
        let around = |numbers: Range<u32>| {
            let none = (Vec3A::INFINITY, Vec3A::NEG_INFINITY);
            numbers
                .map(|number| centre(number as usize))
                .fold(none, |(low, high), centre| (low.min(centre), high.max(centre)))
        };
        let (low, high) = parallel::map_parts(boxes.len(), around)
            .into_iter()
            .reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
            .unwrap_or_default();
        // cells are cubes, the last ends a little behind the last centre
        let extent = (high - low).max_element().max(1e-30);
        let scale = (1u32 << axis_bits) as f32 * 0.9999 / extent;
        let key = |number: usize| {
            let cell = ((centre(number) - low) * scale).to_array();
            code(cell.map(|x| x as u32)) << number_bits | number as u64
        };
        let keys = parallel::collect(boxes.len(), key);
        Self { keys: sorted(keys, 3 * axis_bits + number_bits), number_bits }
    }

    fn number(&self, place: usize) -> u32 {
        (self.keys[place] & ((1 << self.number_bits) - 1)) as u32
    }

    /// The runs of all codes that are to be clusters; made by all threads.
    fn all_runs(&self) -> Vec<Range<usize>> {
        let all = 0..self.keys.len();
        let parts = parallel::parts(all.len());
        if parts == 1 {
            return self.runs(all, MOST);
        }
        let long = self.runs(all, (self.keys.len() / (8 * parts)).max(MOST));
        parallel::map(long, &|long| self.runs(long, MOST)).concat()
    }

    /// The longest runs among these codes that begin with the same bits and are no more than `most`,
    /// or all the same.
    fn runs(&self, codes: Range<usize>, most: usize) -> Vec<Range<usize>> {
        let mut runs = Vec::with_capacity(4 * codes.len() / most);
        let mut waiting = vec![codes];
        while let Some(range) = waiting.pop() {
            let part = &self.keys[range.clone()];
            let [first, .., last] = part else {
                runs.push(range);
                continue;
            };
            let differ = first ^ last;
            if part.len() <= most || differ >> self.number_bits == 0 {
                runs.push(range);
                continue;
            }
            let bit = 1 << differ.ilog2();
            let middle = range.start + part.partition_point(|key| key & bit == 0);
            waiting.extend([middle..range.end, range.start..middle]);
        }
        runs
    }
}

/// The keys in order, of which so many bits count.
fn sorted(mut keys: Vec<u64>, bits: u32) -> Vec<u64> {
    if keys.len() < 1 << DIGIT_BITS {
        keys.sort_unstable();
        return keys;
    }
    let lowest = bits.saturating_sub(2 * DIGIT_BITS);
    let parts = parallel::parts(keys.len());
    let mut keys = by_two_digits(keys, lowest, parts);
    let are_alike = |a: &u64, b: &u64| a >> lowest == b >> lowest;
    match parts {
        1 => keys.chunk_by_mut(are_alike).for_each(<[u64]>::sort_unstable),
        _ => keys.par_chunk_by_mut(are_alike).for_each(<[u64]>::sort_unstable),
    }
    keys
}

/// The code of a cell: that of its place along x has the highest bit.
fn code([x, y, z]: [u32; 3]) -> u64 {
    morton_encode_u64(z, y, x)
}

/// Items side by side that are near each other.
#[derive(Clone, Copy)]
struct Cluster {
    first: usize,
    items: usize,
    around: SetBounds,
}

impl Cluster {
    fn of(first: usize, items: &[Item]) -> Self {
        Self { first, items: items.len(), around: SetBounds::of(items) }
    }

    /// The item that represents the cluster in the top-level tree.
    fn head(&self, number: u32) -> Item {
        Item::of_cluster(&self.around.items.aabb(), number, self.items as u32)
    }
}

/// The clusters of these runs, which are all items one after the other.
fn clusters(runs: &[Range<usize>], items: &mut [Item]) -> Vec<Cluster> {
    let size = runs.len().div_ceil(parallel::parts(items.len()));
    let parts = runs.chunks(size.max(1));
    let lengths = parts.clone().map(|runs| runs.iter().map(ExactSizeIterator::len).sum());
    let mut parts: Vec<_> = parts.clone().zip(parallel::split_mut(items, lengths)).collect();
    let mut clusters = parallel::map(&mut parts, &|(runs, items)| {
        let mut clusters = Vec::with_capacity(runs.len());
        let lengths = runs.iter().map(ExactSizeIterator::len);
        for (run, own) in runs.iter().zip(parallel::split_mut(items, lengths)) {
            add_clusters(run.start, own, &mut clusters);
        }
        clusters
    });
    if clusters.len() > 1 { clusters.concat() } else { clusters.pop().unwrap_or_default() }
}

/// Adds the clusters of a run, whose first item is in that place. Large ones are brought behind the
/// others, to be clusters of their own, where the boxes of all clusters then cost less than half of
/// that of the run.
fn add_clusters(first: usize, items: &mut [Item], clusters: &mut Vec<Cluster>) {
    let whole = Cluster::of(first, items);
    let n = items.len() as f32;
    let area = whole.around.items.half_area();
    let most = area * (2.0 / n).max(0.25);
    let (mut middle, mut of_large) = (0, 0.0);
    for i in 0..items.len() {
        if items[i].half_area() <= most {
            items.swap(i, middle);
            middle += 1;
        } else {
            of_large += items[i].half_area();
        }
    }
    let (others, large) = items.split_at(middle);
    if large.is_empty() || others.is_empty() {
        clusters.push(whole);
        return;
    }
    let apart = Cluster::of(first, others);
    if apart.around.items.half_area() * middle as f32 + of_large < 0.5 * area * n {
        clusters.push(apart);
        let large = large.chunks(1).zip(first + middle..);
        clusters.extend(large.map(|(item, first)| Cluster::of(first, item)));
    } else {
        clusters.push(whole);
    }
}

/// Makes a tree of each cluster at the leaf that stands for it, so `few` boxes being a leaf.
fn within(
    mut nodes: Nodes,
    heads: &[Item],
    clusters: &[Cluster],
    items: &mut [Item],
    few: usize,
) -> Nodes {
    let sizes = Sizes { few, upper_above: MANY, is_parallel: false };
    let items_in_all = items.len();
    let parts = parallel::parts(items_in_all);
    let lengths = clusters.iter().map(|cluster| cluster.items);
    let mut slices: Vec<_> = parallel::split_mut(items, lengths).collect();
    let leaves = nodes.all.iter().zip(0..).filter(|(node, _)| node.is_leaf());
    // of each its place, its cluster and the items of that
    let mut leaves: Vec<(u32, u32, &mut [Item])> = leaves
        .map(|(leaf, place)| {
            let number = heads[leaf.first_index as usize].number();
            (place, number, std::mem::take(&mut slices[number as usize]))
        })
        .collect();
    let build = |items: &mut [Item], number: u32, node, nodes: &mut Nodes, bins: &mut Bins| {
        let Cluster { first, around, .. } = clusters[number as usize];
        let level = MOST_CUTS - LEVELS;
        Set { items, first, around, level, node }.build(nodes, bins, sizes);
    };
    if parts == 1 {
        let mut bins = Bins::NONE;
        nodes.all.reserve(items_in_all / 2);
        let leaves = leaves.into_iter();
        leaves.for_each(|(at, number, items)| build(items, number, at, &mut nodes, &mut bins));
        return nodes;
    }
    let size = leaves.len().div_ceil(parts);
    let built = parallel::map(leaves.chunks_mut(size), &|leaves| {
        let room = leaves.iter().map(|(_, _, items)| items.len()).sum::<usize>() / 2;
        let (mut nodes, mut bins) = (Nodes::with_root(room), Bins::NONE);
        let root = |(place, number, items): &mut (u32, u32, &mut [Item])| {
            build(items, *number, 0, &mut nodes, &mut bins);
            (*place as usize, nodes.all[0])
        };
        let roots: Vec<(usize, Bvh2Node)> = leaves.iter_mut().map(root).collect();
        (roots, nodes)
    });
    nodes.grafted(built)
}

#[cfg(test)]
mod tests {
    use super::super::binned::tests::{assert_few_in_a_leaf, assert_whole_and_the_same};
    use super::*;
    use crate::bvh::build::agglomerated::tests::scattered;

    #[test]
    fn trees_are_whole_and_the_same_for_any_number_of_threads() {
        assert_whole_and_the_same(tree);
    }

    #[test]
    fn leaves_have_a_few_boxes_and_no_more_than_is_asked_for() {
        assert_few_in_a_leaf(tree, FEW);
    }

    #[test]
    fn bits_are_spread() {
        for x in [0, 1, 0b101, 0x15_5555, 0x1f_ffff, 0x12_3456] {
            let spread = |x: u64| (0..21).fold(0, |code, bit| code | (x >> bit & 1) << (3 * bit));
            let [y, z] = [x ^ 0x0f_0f0f, x / 3];
            let expected = spread(x) << 2 | spread(y) << 1 | spread(z);
            assert_eq!(code([x, y, z].map(|x| x as u32)), expected, "{x:x}");
        }
    }

    /// Codes of a run begin with the same bits, and no more of them would fit.
    #[test]
    fn runs_are_as_long_as_may_be() {
        let mut boxes = scattered(3000, 0.01);
        let first = boxes[0];
        boxes[..100].fill(first);
        let keys = Keys::of(&boxes);
        let runs = keys.all_runs();
        assert_eq!(runs.iter().map(|run| run.len()).sum::<usize>(), boxes.len());
        assert!(runs.windows(2).all(|pair| pair[0].end == pair[1].start));
        let code = |place: usize| keys.keys[place] >> keys.number_bits;
        // how many bits codes differ in, from the last
        let differ =
            |a: usize, b: usize| (code(a) ^ code(b)).checked_ilog2().map_or(0, |bit| bit + 1);
        let mut long = 0;
        for run in &runs {
            let own = differ(run.start, run.end - 1);
            assert!(run.len() <= MOST || own == 0);
            long += usize::from(run.len() > MOST);
            // the next larger cell has more than fit
            let larger = (run.start.checked_sub(1).map(|before| differ(before, run.start)))
                .into_iter()
                .chain((run.end < boxes.len()).then(|| differ(run.end - 1, run.end)))
                .min()
                .unwrap();
            assert!(larger > own);
            let within = (0..boxes.len()).filter(|&i| differ(i, run.start) <= larger).count();
            assert!(within > MOST, "{within}");
        }
        assert_eq!(long, 1);
    }

    #[test]
    fn a_large_box_is_a_cluster_of_its_own() {
        let mut boxes = scattered(30, 0.01);
        for aabb in &mut boxes {
            *aabb = Aabb::new(aabb.min * 0.1, aabb.min * 0.1 + 0.01);
        }
        boxes[7] = Aabb::new(Vec3A::splat(-3.0), Vec3A::splat(3.0));
        let mut items: Vec<Item> = (0..30).map(|i| Item::of(&boxes[i], i as u32)).collect();
        let clusters = clusters(&[0..20, 20..30], &mut items);
        let number: Vec<_> =
            clusters.iter().map(|cluster| (cluster.first, cluster.items)).collect();
        assert_eq!(number, [(0, 19), (19, 1), (20, 10)]);
        assert_eq!(items[19].number(), 7);
        assert!(clusters[0].around.items.half_area() < 0.1);
        let head = clusters[2].head(2);
        assert_eq!((head.number(), head.boxes()), (2, 10));
    }
}
