//! A binary tree built from the top down: a set of boxes is divided where the surface-area heuristic, looked at
//! in equal bins of their centres, says that it costs least; then its upper nodes are inserted anew where they cost
//! less.
//!
//! Papers: I. Wald, "On Fast Construction of SAH-based Bounding Volume Hierarchies", RT 2007 (bins); D. Meister,
//! J. Bittner, "Parallel Reinsertion for Bounding Volume Hierarchy Optimization", Computer Graphics Forum 37(2), 2018,
//! as implemented by obvhs. Deviations: all three axes are binned; a side costs what its blocks of triangles cost;
//! few boxes have few bins, the fewest none; only nodes of many boxes are inserted anew.

use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::node::Bvh2Node;
use obvhs::bvh2::reinsertion::ReinsertionOptimizer;
use wide::{f32x4, i32x4};

use crate::geometry::lanes::{Four, Lanes};
use crate::parallel;
use crate::structures::wide_bvh::collapse::blocks;

/// Bins of an axis: a few, one more for so many boxes, at most so many.
const FEWEST_BINS: usize = 4;
const BOXES_A_BIN: usize = 20;
const MOST_BINS: usize = 32;

/// So few boxes are not divided: they mostly share a block.
const FEW: u32 = 3;

/// Nodes of no more boxes than this stay where they are.
const LEAST_INSERTED: usize = 64;

/// Levels below which sets are halved as they lie: with those of a balanced tree a stack of obvhs has room for them.
const MOST_CUTS: u32 = 48;

/// A box and its number, which stands in the fourth lane of `low`.
#[derive(Debug, Clone, Copy)]
struct Item(Bounds);

impl Item {
    fn of(aabb: &Aabb, number: u32) -> Self {
        let ([x, y, z], [u, v, w]) = (aabb.min.to_array(), aabb.max.to_array());
        Self(Bounds {
            low: f32x4::new([x, y, z, f32::from_bits(number)]),
            high: f32x4::new([u, v, w, 0.0]),
        })
    }

    fn number(&self) -> u32 {
        self.0.low.to_array()[3].to_bits()
    }

    /// Twice the centre.
    #[inline(always)]
    fn centre(&self) -> f32x4 {
        (self.0.low + self.0.high) & XYZ
    }
}

/// All ones for the axes. A number would be a subnormal one, slow to multiply on some processors.
const XYZ: f32x4 =
    f32x4::new([f32::from_bits(u32::MAX), f32::from_bits(u32::MAX), f32::from_bits(u32::MAX), 0.0]);

/// A box; of what is in the fourth lanes nothing is known.
#[derive(Debug, Clone, Copy)]
struct Bounds {
    low: f32x4,
    high: f32x4,
}

impl Bounds {
    const NONE: Self =
        Self { low: f32x4::splat(f32::INFINITY), high: f32x4::splat(f32::NEG_INFINITY) };

    #[inline(always)]
    fn add(&mut self, other: &Self) {
        self.low = self.low.lesser(other.low);
        self.high = self.high.greater(other.high);
    }

    /// Adds the other where the mask is set.
    #[inline(always)]
    fn add_where(&mut self, mask: i32x4, other: &Self) {
        self.add(&Self {
            low: other.low.where_set(mask, Self::NONE.low),
            high: other.high.where_set(mask, Self::NONE.high),
        });
    }

    #[inline(always)]
    fn half_area(&self) -> f32 {
        let [x, y, z, _] = (self.high - self.low).to_array();
        x * y + y * z + z * x
    }

    fn aabb(&self) -> Aabb {
        let ([x, y, z, _], [u, v, w, _]) = (self.low.to_array(), self.high.to_array());
        Aabb::new([x, y, z].into(), [u, v, w].into())
    }
}

/// Boxes of items and of their centres.
#[derive(Clone, Copy)]
struct Around {
    items: Bounds,
    centres: Bounds,
}

impl Around {
    const NONE: Self = Self { items: Bounds::NONE, centres: Bounds::NONE };

    #[inline(always)]
    fn add(&mut self, item: &Item) {
        let centre = item.centre();
        self.items.add(&item.0);
        self.centres.add(&Bounds { low: centre, high: centre });
    }

    /// Adds the item where the mask is set.
    #[inline(always)]
    fn add_where(&mut self, mask: i32x4, item: &Item) {
        let centre = item.centre();
        self.items.add_where(mask, &item.0);
        self.centres.add_where(mask, &Bounds { low: centre, high: centre });
    }

    fn of(items: &[Item]) -> Self {
        let mut around = Self::NONE;
        items.iter().for_each(|item| around.add(item));
        around
    }
}

/// The tree over these boxes, so many in a leaf at most; the same for any number of threads. Some of its nodes may be
/// below no other.
pub(super) fn tree(boxes: &[Aabb], longest_leaf: u32) -> Bvh2 {
    let (mut bvh, upper) = divided(boxes, longest_leaf, 1);
    insert_anew(&mut bvh, upper);
    bvh
}

/// The tree whose root is on this level, and its nodes of many boxes.
fn divided(boxes: &[Aabb], longest_leaf: u32, level: u32) -> (Bvh2, Vec<u32>) {
    let few = FEW.min(longest_leaf) as usize;
    let mut items: Vec<Item> = boxes.iter().zip(0..).map(|(aabb, i)| Item::of(aabb, i)).collect();
    // a leaf of several boxes leaves places of nodes below it as they are
    let unused = Bvh2Node::new(Aabb::default(), 1, 0);
    let mut nodes = vec![unused; (2 * items.len()).saturating_sub(1)];
    let mut upper = Vec::new();
    if let Some((root, below)) = nodes.split_first_mut() {
        let around = Around::of(&items);
        let set = Set { items: &mut items, first: 0, around, level, node: root, below, pairs: 1 };
        upper = set.build(few, parallel::forks());
    }
    let primitive_indices = items.iter().map(Item::number).collect();
    (Bvh2 { nodes, primitive_indices, ..Bvh2::default() }, upper)
}

/// Inserts the largest of these nodes anew, half of them, then fewer and fewer, as obvhs does.
fn insert_anew(bvh: &mut Bvh2, mut upper: Vec<u32>) {
    let mut reinsertion = ReinsertionOptimizer::default();
    for part in (2..64).step_by(4) {
        let most = upper.len() / part;
        if most == 0 {
            return;
        }
        let area = |node: &u32| bvh.nodes[*node as usize].aabb().half_area();
        upper.sort_unstable_by(|a, b| area(b).total_cmp(&area(a)).then(a.cmp(b)));
        reinsertion.run_with_candidates(bvh, &upper[..most], 1);
    }
}

/// Items that a node is to be made of, at least one.
struct Set<'a> {
    items: &'a mut [Item],
    /// The place of the first.
    first: usize,
    around: Around,
    level: u32,
    node: &'a mut Bvh2Node,
    /// The nodes below it: pairs of siblings, the first at the place `pairs`.
    below: &'a mut [Bvh2Node],
    pairs: usize,
}

impl Set<'_> {
    /// Makes the node and all below it, so `few` items being a leaf; gives the places of those below it that are of
    /// many items.
    fn build(self, few: usize, forks: u32) -> Vec<u32> {
        let (mut upper, mut bins) = (Vec::new(), Bins::NONE);
        let mut waiting = vec![self];
        while let Some(set) = waiting.pop() {
            let (n, pair) = (set.items.len(), set.pairs as u32);
            let Some([a, b]) = set.divided(few, &mut bins) else { continue };
            let places = [(&a, pair), (&b, pair + 1)];
            let many = places.into_iter().filter(|(set, _)| set.items.len() > LEAST_INSERTED);
            upper.extend(many.map(|(_, place)| place));
            if forks > 0 && parallel::is_worth_a_fork(n) {
                let (a, b) = rayon::join(|| a.build(few, forks - 1), || b.build(few, forks - 1));
                upper.extend(a);
                upper.extend(b);
            } else {
                waiting.extend([b, a]);
            }
        }
        upper
    }

    /// Makes the node, and gives both sides of the cut that costs least; none of a leaf.
    fn divided(self, few: usize, bins: &mut Bins) -> Option<[Self; 2]> {
        let Self { items, first, around, level, node, below, pairs } = self;
        let (bounds, n) = (around.items.aabb(), items.len());
        let (false, [lower_node, upper_node, below @ ..]) = (n <= few, below) else {
            *node = Bvh2Node::new(bounds, n as u32, first as u32);
            return None;
        };
        *node = Bvh2Node::new(bounds, 0, pairs as u32);
        let cut = match level {
            ..=MOST_CUTS => Cut::of(items, &around.centres, bins),
            _ => None,
        };
        let (middle, [lower, upper]) = match cut {
            Some(cut) => cut.partition(items),
            None => (n / 2, [Around::of(&items[..n / 2]), Around::of(&items[n / 2..])]),
        };
        let (lower_items, upper_items) = items.split_at_mut(middle);
        let (lower_below, upper_below) = below.split_at_mut(2 * (middle - 1));
        let level = level + 1;
        Some([
            Set {
                items: lower_items,
                first,
                around: lower,
                level,
                node: lower_node,
                below: lower_below,
                pairs: pairs + 2,
            },
            Set {
                items: upper_items,
                first: first + middle,
                around: upper,
                level,
                node: upper_node,
                below: upper_below,
                pairs: pairs + 2 * middle,
            },
        ])
    }
}

/// Which bins the centres of items are in.
#[derive(Clone, Copy)]
struct Binning {
    low: f32x4,
    scale: f32x4,
}

impl Binning {
    fn of(centres: &Bounds, bins: usize) -> Self {
        let extent = (centres.high - centres.low).to_array();
        // the last bin ends a little behind the last centre; no bins are on an axis along which all are alike
        let scale = |extent: f32| if extent > 1e-30 { bins as f32 * 0.9999 / extent } else { 0.0 };
        let [x, y, z, _] = extent;
        Self { low: centres.low, scale: f32x4::new([scale(x), scale(y), scale(z), 0.0]) }
    }

    #[inline(always)]
    fn bins(&self, item: &Item) -> [i32; 4] {
        let places: i32x4 = ((item.centre() - self.low) * self.scale).truncate();
        places.to_array()
    }
}

/// What lies in the bins of each axis.
struct Bins {
    bounds: [[Bounds; MOST_BINS]; 3],
    numbers: [[u32; MOST_BINS]; 3],
}

impl Bins {
    const NONE: Self =
        Self { bounds: [[Bounds::NONE; MOST_BINS]; 3], numbers: [[0; MOST_BINS]; 3] };

    /// Counts the items into so many bins.
    #[inline(always)]
    fn fill(&mut self, count: usize, binning: &Binning, items: &[Item]) {
        self.bounds.iter_mut().for_each(|of_axis| of_axis[..count].fill(Bounds::NONE));
        self.numbers.iter_mut().for_each(|of_axis| of_axis[..count].fill(0));
        for item in items {
            let axes = self.bounds.iter_mut().zip(&mut self.numbers);
            for ((bounds, numbers), place) in axes.zip(binning.bins(item)) {
                let bin = place as usize & (MOST_BINS - 1);
                bounds[bin].add(&item.0);
                numbers[bin] += 1;
            }
        }
    }
}

/// A cut between two bins.
struct Cut {
    binning: Binning,
    axis: usize,
    /// The first bin of the upper side.
    bin: i32,
}

impl Cut {
    /// The cut that costs least; none where all centres are alike.
    fn of(items: &[Item], centres: &Bounds, bins: &mut Bins) -> Option<Self> {
        let count = (FEWEST_BINS + items.len() / BOXES_A_BIN).min(MOST_BINS);
        let binning = Binning::of(centres, count);
        bins.fill(count, &binning, items);
        let blocks = |items: u32| blocks(items) as f32;
        let (mut least, mut best) = (f32::INFINITY, None);
        for axis in 0..3 {
            let (bounds, numbers) = (&bins.bounds[axis][..count], &bins.numbers[axis][..count]);
            let mut above = [0.0; MOST_BINS];
            let (mut around, mut n) = (Bounds::NONE, 0);
            for bin in (1..count).rev() {
                around.add(&bounds[bin]);
                n += numbers[bin];
                above[bin] = around.half_area() * blocks(n);
            }
            // all centres are alike; else the first and the last bin have items
            if n == 0 {
                continue;
            }
            let (mut around, mut n) = (Bounds::NONE, 0);
            for bin in 1..count {
                around.add(&bounds[bin - 1]);
                n += numbers[bin - 1];
                let cost = above[bin] + around.half_area() * blocks(n);
                if cost < least {
                    (least, best) = (cost, Some(Self { binning, axis, bin: bin as i32 }));
                }
            }
        }
        best
    }

    /// Brings the items of the lower side before the others: how many they are, and what is around both. Without
    /// branches (N. Lomuto's way to partition), as no processor can guess on which side an item is.
    fn partition(&self, items: &mut [Item]) -> (usize, [Around; 2]) {
        let [mut lower, mut upper] = [Around::NONE; 2];
        let mut middle = 0;
        for i in 0..items.len() {
            let item = items[i];
            let is_lower = self.binning.bins(&item)[self.axis] < self.bin;
            items[i] = items[middle];
            items[middle] = item;
            middle += usize::from(is_lower);
            let mask = i32x4::splat(-i32::from(is_lower));
            lower.add_where(mask, &item);
            upper.add_where(!mask, &item);
        }
        (middle, [lower, upper])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::structures::obvhs::builder::tests::{fault, nested, scattered};

    fn built(boxes: &[Aabb], threads: usize) -> Bvh2 {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| tree(boxes, 16))
    }

    #[test]
    fn trees_are_whole_and_the_same_for_any_number_of_threads() {
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
                let same = |(a, b): (&Bvh2Node, &Bvh2Node)| {
                    a.aabb() == b.aabb() && a.first_index == b.first_index
                };
                assert!(other.nodes.iter().zip(&one.nodes).all(same), "{threads} threads");
            }
        }
        assert!(tree(&[], 16).nodes.is_empty());
    }

    #[test]
    fn leaves_have_a_few_boxes_and_no_more_than_is_asked_for() {
        let boxes = scattered(3000, 0.01);
        for longest in [1, 2, 3, 16] {
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
            assert_eq!(most, FEW.min(longest));
        }
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
        let around = Around::of(&items);
        let of =
            |items: &[Item], around: &Around| Cut::of(items, &around.centres, &mut { Bins::NONE });
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
        assert!(of(&items[..1], &Around::of(&items[..1])).is_none());
    }
}
