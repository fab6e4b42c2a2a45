//! Chooses the nodes of a binary tree that become children of an eight-wide node, and the subtrees
//! that become leaves.
//!
//! Paper: H. Ylitie, T. Karras, S. Laine, "Efficient Incoherent Ray Traversal on GPUs Through
//! Compressed Wide BVHs", HPG 2017, section 3.1: the least expected cost of a subtree as one to
//! eight roots, from the leaves up. Deviations: a leaf costs what its blocks of triangles cost, not
//! its triangles; children have no order, since traversal sorts them.

use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::node::Bvh2Node;
use wide::f32x8;

use crate::bvh::build::agglomerated::limit_levels;
use crate::bvh::items::Groups;
use crate::bvh::node::WIDTH;
use crate::geometry::lanes::{Eight, Lanes};
use crate::parallel::forks;
use crate::primitives::TriangleBlock;

/// Upper bound on the depth of the binary tree; collapsing only makes it shallower.
pub(super) const LEVELS: u32 = 96;

/// Cost model that the collapse minimises.
#[derive(Debug, Clone, Copy)]
pub(super) struct Costs {
    /// Cost of a visit to a node, that of a block of triangles being 1.
    pub(super) node: f32,
    /// Primitives of a leaf at most; one of the binary tree's own leaves may have more.
    pub(super) longest_leaf: u32,
}

/// How the least cost of an inner node's subtree is reached, in 49 bits.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
struct Choice(u64);

impl Choice {
    /// Bits of each number of roots and of each side.
    const BITS: usize = 3;
    const SIDES: usize = Self::BITS * WIDTH;
    const LEAF: u64 = 1 << (2 * Self::SIDES);

    /// `is_leaf`: the subtree becomes a leaf. By lane `i`: the number of roots less one if at most `i +
    /// 1` are allowed, and how many of `i + 1` roots are on the lower child's side.
    #[inline(always)]
    fn of(is_leaf: bool, roots: f32x8, lower: f32x8) -> Self {
        let leaf = if is_leaf { Self::LEAF } else { 0 };
        Self(leaf | Self::packed(lower) << Self::SIDES | Self::packed(roots))
    }

    /// Whole numbers below 8 as 3 bits each, which are 24 in all: a sum in f32 is exact.
    #[inline(always)]
    fn packed(numbers: f32x8) -> u64 {
        const PLACES: f32x8 =
            f32x8::new([1.0, 8.0, 64.0, 512.0, 4096.0, 32768.0, 262_144.0, 2_097_152.0]);
        u64::from((numbers * PLACES).reduce_add() as u32)
    }

    fn is_leaf(self) -> bool {
        self.0 & Self::LEAF != 0
    }

    fn number(self, shift: usize) -> usize {
        (self.0 >> shift) as usize & (WIDTH - 1)
    }

    /// Number of roots if at most this many are allowed.
    fn roots(self, allowed: usize) -> usize {
        self.number(Self::BITS * (allowed - 1)) + 1
    }

    /// Number of these roots on the lower child's side.
    fn lower(self, roots: usize) -> usize {
        self.number(Self::SIDES + Self::BITS * (roots - 1))
    }
}

/// Summary of a subtree, computed bottom-up.
#[derive(Debug, Clone, Copy)]
struct Subtree {
    /// The least cost as at most 1 to [`WIDTH`] roots.
    cost: [f32; WIDTH],
    primitives: u32,
    levels: u32,
}

const NUMBERS: f32x8 = f32x8::new([0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]);

/// A binary tree and how it is collapsed.
pub(super) struct Collapse<'a> {
    bvh: &'a Bvh2,
    groups: &'a Groups,
    /// By pairs of children: where their parent keeps its own. Pairs lie side by side, at odd
    /// places.
    choices: Vec<Choice>,
}

/// The place of an inner node's choice.
fn pair_of(node: &Bvh2Node) -> usize {
    node.first_index as usize / 2
}

/// The items of a leaf.
fn items<'a>(bvh: &'a Bvh2, leaf: &Bvh2Node) -> &'a [u32] {
    &bvh.primitive_indices[leaf.first_index as usize..][..leaf.prim_count as usize]
}

fn primitives_of(bvh: &Bvh2, groups: &Groups, leaf: &Bvh2Node) -> u32 {
    items(bvh, leaf).iter().map(|item| groups.ids(item).len() as u32).sum()
}

/// Blocks of triangles that so many primitives of a leaf take.
pub(super) fn blocks(primitives: u32) -> u32 {
    primitives.div_ceil(TriangleBlock::<f32>::LANES as u32)
}

impl<'a> Collapse<'a> {
    /// Plans all subtrees of a tree that is not empty, after those that reach below `levels` have
    /// been halved.
    pub(super) fn plan(bvh: &'a mut Bvh2, groups: &'a Groups, costs: Costs, levels: u32) -> Self {
        let (mut choices, found) = Self::choices(bvh, groups, costs);
        if found > levels {
            limit_levels(bvh, levels);
            (choices, _) = Self::choices(bvh, groups, costs);
        }
        Self { bvh, groups, choices }
    }

    /// The choices, and the tree's levels.
    fn choices(bvh: &Bvh2, groups: &Groups, costs: Costs) -> (Vec<Choice>, u32) {
        let choices = bytemuck::zeroed_vec(bvh.nodes.len() / 2 + 1);
        let planner = CollapsePlanner { bvh, groups, costs, choices };
        let root = planner.subtree(0, forks());
        let choices = planner.choices.into_iter().map(|bits| Choice(bits.into_inner())).collect();
        (choices, root.map_or(0, |root| root.levels))
    }

    /// How many nodes have two children, at most.
    pub(super) fn inner_nodes(&self) -> usize {
        self.choices.len()
    }

    /// The box of a subtree.
    pub(super) fn bounds(&self, node: u32) -> &'a Aabb {
        self.bvh.nodes[node as usize].aabb()
    }

    /// Returns whether a subtree becomes a leaf.
    pub(super) fn is_leaf(&self, node: u32) -> bool {
        let node = &self.bvh.nodes[node as usize];
        node.is_leaf() || self.choices[pair_of(node)].is_leaf()
    }

    /// The subtrees that become the children of a node that is no leaf.
    pub(super) fn children(&self, node: u32) -> ([u32; WIDTH], usize) {
        let (mut children, mut n) = ([0; WIDTH], 0);
        // a node itself is divided in any case
        let mut waiting = [(0, 0); WIDTH];
        waiting[0] = (node, WIDTH);
        let (mut left, mut is_root) = (1, true);
        while left > 0 {
            left -= 1;
            let (at, allowed) = waiting[left];
            let node = &self.bvh.nodes[at as usize];
            let choice = if node.is_leaf() { None } else { Some(&self.choices[pair_of(node)]) };
            let roots = match choice {
                _ if is_root => WIDTH,
                Some(choice) => choice.roots(allowed),
                None => 1,
            };
            is_root = false;
            let (Some(choice), 2..) = (choice, roots) else {
                children[n] = at;
                n += 1;
                continue;
            };
            let lower = choice.lower(roots);
            waiting[left] = (node.first_index + 1, roots - lower);
            waiting[left + 1] = (node.first_index, lower);
            left += 2;
        }
        (children, n)
    }

    /// Adds the ids of a subtree's primitives.
    pub(super) fn ids(&self, node: u32, waiting: &mut Vec<u32>, ids: &mut Vec<u32>) {
        waiting.push(node);
        while let Some(node) = waiting.pop() {
            let inner = &self.bvh.nodes[node as usize];
            if inner.is_leaf() {
                let items = items(self.bvh, inner).iter();
                items.for_each(|item| ids.extend_from_slice(self.groups.ids(item)));
            } else {
                waiting.extend([inner.first_index + 1, inner.first_index]);
            }
        }
    }
}

struct CollapsePlanner<'a> {
    bvh: &'a Bvh2,
    groups: &'a Groups,
    costs: Costs,
    /// By pairs of children, each written by the one thread that looks at their parent.
    choices: Vec<AtomicU64>,
}

impl CollapsePlanner<'_> {
    /// A subtree once all below it has been looked at: both sides at once, `forks` times one below
    /// the other.
    fn subtree(&self, at: u32, forks: u32) -> Option<Subtree> {
        let node = &self.bvh.nodes[at as usize];
        if forks == 0 || node.is_leaf() {
            return self.alone(at);
        }
        let (lower, upper) = rayon::join(
            || self.subtree(node.first_index, forks - 1),
            || self.subtree(node.first_index + 1, forks - 1),
        );
        Some(self.joined(node, &lower?, &upper?))
    }

    /// The same by this thread. What is not finished is on two stacks, so that each node is read
    /// once.
    fn alone(&self, root: u32) -> Option<Subtree> {
        let mut done: Vec<Subtree> = Vec::new();
        // nodes, and whether what is below them is done
        let mut waiting = vec![(root, false)];
        while let Some((at, is_below_done)) = waiting.pop() {
            let node = &self.bvh.nodes[at as usize];
            if node.is_leaf() {
                let primitives = primitives_of(self.bvh, self.groups, node);
                let cost = [node.aabb().half_area() * blocks(primitives) as f32; WIDTH];
                done.push(Subtree { cost, primitives, levels: 1 });
            } else if !is_below_done {
                waiting.push((at, true));
                waiting.extend([(node.first_index + 1, false), (node.first_index, false)]);
            } else if let (Some(upper), Some(lower)) = (done.pop(), done.pop()) {
                done.push(self.joined(node, &lower, &upper));
            }
        }
        done.pop()
    }

    #[inline(always)]
    fn joined(&self, node: &Bvh2Node, lower: &Subtree, upper: &Subtree) -> Subtree {
        let (subtree, choice) = joined(lower, upper, node.aabb().half_area(), self.costs);
        self.choices[pair_of(node)].store(choice.0, Relaxed);
        subtree
    }
}

/// The subtree of an inner node whose box has this half area, from those of its children.
#[inline(always)]
fn joined(lower: &Subtree, upper: &Subtree, area: f32, costs: Costs) -> (Subtree, Choice) {
    let primitives = lower.primitives + upper.primitives;
    // so many roots of the lower child's: the others are the upper one's, so many lanes further on
    let mut shared = [f32x8::splat(0.0); WIDTH - 1];
    for of_lower in 1..WIDTH {
        let of_upper = moved_up(upper.cost, of_lower, f32::INFINITY);
        shared[of_lower - 1] = f32x8::splat(lower.cost[of_lower - 1]) + of_upper;
    }
    let [a, b, c, d, e, f, g] = shared;
    let best = a.lesser(b).lesser(c.lesser(d)).lesser(e.lesser(f).lesser(g));
    let mut sides = f32x8::splat(0.0);
    for of_lower in (1..WIDTH).rev() {
        let is_best = shared[of_lower - 1].equal(best);
        sides = f32x8::splat(of_lower as f32).where_set(is_best, sides);
    }
    let mut cost = best.to_array();
    let as_leaf = area * blocks(primitives) as f32;
    let as_node = cost[WIDTH - 1] + area * costs.node;
    let is_leaf = primitives <= costs.longest_leaf && as_leaf <= as_node;
    cost[0] = if is_leaf { as_leaf } else { as_node };
    // no more roots than pay
    let own = f32x8::new(cost);
    let least = scanned(own, f32::INFINITY, f32x8::lesser);
    let pays = own.below(moved_up(least.to_array(), 1, f32::INFINITY));
    let roots = scanned(NUMBERS.where_set(pays, f32x8::splat(0.0)), 0.0, f32x8::greater);
    let cost = least.to_array();
    let levels = 1 + lower.levels.max(upper.levels);
    (Subtree { cost, primitives, levels }, Choice::of(is_leaf, roots, sides))
}

/// Lanes so many places further on, this number in those below.
#[inline(always)]
fn moved_up(lanes: [f32; WIDTH], places: usize, below: f32) -> f32x8 {
    // a shuffle: eight lanes read at once that were just written one by one would be waited for
    f32x8::new(std::array::from_fn(|i| if i < places { below } else { lanes[i - places] }))
}

/// By lane what `join` makes of those up to it; `none` changes nothing.
#[inline(always)]
fn scanned(mut lanes: f32x8, none: f32, join: impl Fn(f32x8, f32x8) -> f32x8) -> f32x8 {
    for places in [1, 2, 4] {
        lanes = join(lanes, moved_up(lanes.to_array(), places, none));
    }
    lanes
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::structures::test_scenes::Random;

    /// As the paper has it: every way to share so many roots between both sides, the first of the
    /// best.
    fn shared(lower: &Subtree, upper: &Subtree, roots: usize) -> (f32, u8) {
        let mut best = (f32::INFINITY, 0);
        for of_lower in 1..roots {
            let cost = lower.cost[of_lower - 1] + upper.cost[roots - of_lower - 1];
            if cost < best.0 {
                best = (cost, of_lower as u8);
            }
        }
        best
    }

    #[test]
    fn lanes_find_the_least_cost_of_every_number_of_roots() {
        let mut random = Random(5);
        let (mut leaves, mut divided) = (0, 0);
        for round in 0..3000 {
            // on a coarse lattice, so that costs tie; more roots cost no more
            let mut subtree = || {
                let mut cost =
                    [0; WIDTH].map(|_| (random.unit() * 16.0).floor() as f32 / 4.0 + 0.25);
                cost.sort_by(|a, b| b.total_cmp(a));
                Subtree { cost, primitives: 1 + round % 7, levels: 1 + round % 3 }
            };
            let (lower, upper) = (subtree(), subtree());
            let costs = Costs { node: 1.0, longest_leaf: 10 };
            let area = (random.unit() * 8.0) as f32;
            let (all, choice) = joined(&lower, &upper, area, costs);
            assert_eq!((all.primitives, all.levels), (2 * (1 + round % 7), 2 + round % 3));
            let as_node = shared(&lower, &upper, WIDTH).0 + area;
            let as_leaf = area * blocks(all.primitives) as f32;
            let is_leaf = all.primitives <= 10 && as_leaf <= as_node;
            assert_eq!(choice.is_leaf(), is_leaf);
            let mut least = (if is_leaf { as_leaf } else { as_node }, 1);
            assert_eq!((all.cost[0], choice.roots(1)), least);
            for roots in 2..=WIDTH {
                let (cost, of_lower) = shared(&lower, &upper, roots);
                assert_eq!(choice.lower(roots), usize::from(of_lower));
                if cost < least.0 {
                    least = (cost, roots);
                }
                assert_eq!((all.cost[roots - 1], choice.roots(roots)), least, "{roots}");
            }
            leaves += u32::from(is_leaf);
            divided += u32::from(least.1 > 1);
        }
        assert!(leaves > 100 && divided > 100, "{leaves} {divided}");
    }
}
