//! Which nodes of a binary tree become the children of an eight-wide one, and which subtrees leaves.
//!
//! Paper: H. Ylitie, T. Karras, S. Laine, "Efficient Incoherent Ray Traversal on GPUs Through
//! Compressed Wide BVHs", HPG 2017, section 3.1: the least expected cost of a subtree as one to eight
//! roots, from the leaves up. Deviations: a leaf costs what its blocks of triangles cost, not its
//! triangles; children have no order, since traversal sorts them.

use obvhs::bvh2::Bvh2;

use crate::primitives::TriangleBlock;
use crate::structures::obvhs::items::Groups;

/// Children of a node at most.
pub(super) const WIDTH: usize = 8;

/// What the collapse minimises.
#[derive(Debug, Clone, Copy)]
pub(super) struct Costs {
    /// Cost of a visit to a node, that of a block of triangles being 1.
    pub(super) node: f32,
    /// Primitives of a leaf at most; one of the binary tree's own leaves may have more.
    pub(super) longest_leaf: u32,
}

/// The least cost of a subtree as at most 1 to [`WIDTH`] roots, and how it is reached.
#[derive(Debug, Clone, Copy)]
struct CollapsePlan {
    cost: [f32; WIDTH],
    /// Where at most `i + 1` roots are allowed: how many there are.
    roots: [u8; WIDTH],
    /// Where there are `i + 1` roots, two or more: those on the lower child's side.
    lower: [u8; WIDTH],
    primitives: u32,
    is_leaf: bool,
}

/// A binary tree and how it is collapsed.
pub(super) struct Collapse<'a> {
    bvh: &'a Bvh2,
    groups: &'a Groups,
    plans: Vec<CollapsePlan>,
}

impl<'a> Collapse<'a> {
    /// Plans all subtrees.
    pub(super) fn plan(bvh: &'a Bvh2, groups: &'a Groups, costs: Costs) -> Self {
        let nothing = CollapsePlan {
            cost: [0.0; WIDTH],
            roots: [1; WIDTH],
            lower: [0; WIDTH],
            primitives: 0,
            is_leaf: true,
        };
        let mut this = Self { bvh, groups, plans: vec![nothing; bvh.nodes.len()] };
        // parents before children
        let mut order: Vec<u32> = (0..bvh.nodes.len().min(1) as u32).collect();
        let mut next = 0;
        while let Some(&node) = order.get(next) {
            next += 1;
            let node = &bvh.nodes[node as usize];
            if !node.is_leaf() {
                order.extend([node.first_index, node.first_index + 1]);
            }
        }
        for &node in order.iter().rev() {
            this.plan_one(node as usize, costs);
        }
        this
    }

    fn plan_one(&mut self, index: usize, costs: Costs) {
        let node = &self.bvh.nodes[index];
        let area = node.aabb().half_area();
        let of_leaf =
            |primitives: u32| area * primitives.div_ceil(TriangleBlock::<f32>::LANES as u32) as f32;
        if node.is_leaf() {
            let primitives = self.items(index).map(|i| self.groups.ids(i).len() as u32).sum();
            let plan = &mut self.plans[index];
            plan.primitives = primitives;
            plan.cost = [of_leaf(primitives); WIDTH];
            return;
        }
        let [a, b] = [0, 1].map(|k| &self.plans[node.first_index as usize + k]);
        let mut plan = CollapsePlan {
            cost: [f32::INFINITY; WIDTH],
            roots: [1; WIDTH],
            lower: [0; WIDTH],
            primitives: a.primitives + b.primitives,
            is_leaf: false,
        };
        for roots in 2..=WIDTH {
            for lower in 1..roots {
                let cost = a.cost[lower - 1] + b.cost[roots - lower - 1];
                if cost < plan.cost[roots - 1] {
                    plan.cost[roots - 1] = cost;
                    plan.lower[roots - 1] = lower as u8;
                }
            }
        }
        let (as_leaf, as_node) =
            (of_leaf(plan.primitives), plan.cost[WIDTH - 1] + area * costs.node);
        plan.is_leaf = plan.primitives <= costs.longest_leaf && as_leaf <= as_node;
        plan.cost[0] = if plan.is_leaf { as_leaf } else { as_node };
        for i in 1..WIDTH {
            plan.roots[i] = i as u8 + 1;
            if plan.cost[i] >= plan.cost[i - 1] {
                plan.cost[i] = plan.cost[i - 1];
                plan.roots[i] = plan.roots[i - 1];
            }
        }
        self.plans[index] = plan;
    }

    fn items(&self, node: usize) -> impl Iterator<Item = &'a u32> + use<'a> {
        let node = &self.bvh.nodes[node];
        let items = node.first_index as usize..(node.first_index + node.prim_count) as usize;
        self.bvh.primitive_indices[items].iter()
    }

    /// Whether a subtree becomes a leaf.
    pub(super) fn is_leaf(&self, node: u32) -> bool {
        self.plans[node as usize].is_leaf
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
            let (node, allowed) = waiting[left];
            let plan = &self.plans[node as usize];
            let roots = if is_root { WIDTH } else { usize::from(plan.roots[allowed - 1]) };
            is_root = false;
            if roots == 1 {
                children[n] = node;
                n += 1;
                continue;
            }
            let lower = usize::from(plan.lower[roots - 1]);
            let first = self.bvh.nodes[node as usize].first_index;
            waiting[left] = (first + 1, roots - lower);
            waiting[left + 1] = (first, lower);
            left += 2;
        }
        (children, n)
    }

    /// How many nodes there will be, and how many blocks of triangles in all leaves.
    pub(super) fn sizes(&self) -> (usize, usize) {
        let (mut nodes, mut blocks) = (0, 0);
        let mut waiting = vec![0];
        while let Some(node) = waiting.pop() {
            let plan = &self.plans[node as usize];
            if plan.is_leaf {
                blocks += plan.primitives.div_ceil(TriangleBlock::<f32>::LANES as u32) as usize;
            } else {
                nodes += 1;
                let (children, n) = self.children(node);
                waiting.extend_from_slice(&children[..n]);
            }
        }
        (nodes, blocks)
    }

    /// The ids of a subtree's primitives.
    pub(super) fn ids(&self, node: u32, ids: &mut Vec<u32>) {
        let mut waiting = vec![node];
        while let Some(node) = waiting.pop() {
            let inner = &self.bvh.nodes[node as usize];
            if inner.is_leaf() {
                self.items(node as usize).for_each(|i| ids.extend_from_slice(self.groups.ids(i)));
            } else {
                waiting.extend([inner.first_index + 1, inner.first_index]);
            }
        }
    }
}
