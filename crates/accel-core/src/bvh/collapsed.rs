//! The eight-wide nodes and the leaves that a planned collapse makes, numbered, and which of a node's
//! children comes first where any hit ends a query.
//!
//! Paper: T. Ize, C. Hansen, "RTSAH Traversal Order for Occlusion Rays", Computer Graphics Forum
//! 30(2), 2011: the child first with the most hits for what it costs. Deviation: that a ray which
//! meets a child hits something in it is taken to be as likely as the areas of its leaves are large.

use super::collapse::Collapse;
use super::node::{LEAF, WIDTH};
use crate::parallel::{self, ForkedTree};

/// The nodes of the collapsed tree, the first its root, none if that is a leaf; children come after
/// their parents.
#[derive(Default)]
pub(super) struct CollapsedTree {
    pub(super) nodes: Vec<CollapsedNode>,
    /// The ids of all leaves, one after the other, and where each ends.
    ids: Vec<u32>,
    ends: Vec<usize>,
}

/// A subtree that became a child of a node.
#[derive(Clone, Copy, Default)]
pub(super) struct Child {
    pub(super) subtree: u32,
    /// A node's number, or a leaf's with [`LEAF`].
    pub(super) place: u32,
    /// That of its box.
    half_area: f32,
}

/// A node that is no leaf.
#[derive(Clone, Copy, Default)]
pub(super) struct CollapsedNode {
    children: [Child; WIDTH],
    /// It has so many of them.
    number: usize,
    /// What its children add up to; none until they are in order.
    sum: Option<Areas>,
}

impl CollapsedNode {
    pub(super) fn children(&self) -> &[Child] {
        &self.children[..self.number]
    }

    /// The same node where the numbers of nodes and of leaves are larger by so much.
    fn moved(mut self, (nodes, leaves): (u32, u32)) -> Self {
        for Child { place, .. } in &mut self.children[..self.number] {
            *place += if *place & LEAF == 0 { nodes } else { leaves };
        }
        self
    }
}

impl CollapsedTree {
    /// The nodes and leaves of a collapse; the same for any number of threads.
    pub(super) fn of(collapse: &Collapse<'_>) -> Self {
        let mut tree = Self::default();
        if collapse.is_leaf(0) {
            tree.add_leaf(collapse, 0, &mut Vec::new());
            return tree;
        }
        if !parallel::should_parallelize(collapse.inner_nodes()) {
            return Self::forked(collapse, 0, 0).piece;
        }
        // a level of eight-wide nodes is three of binary ones
        let forked = Self::forked(collapse, 0, parallel::forks().div_ceil(3));
        Self::joined(&forked.pieces(|tree| tree.nodes.len()))
    }

    fn joined(pieces: &[(usize, Self)]) -> Self {
        // nodes and leaves in front of a piece, and ids
        let (mut shift, mut ids_in_front) = ((0, 0), 0);
        let root = [CollapsedNode::default()];
        let (mut roots, mut nodes) = (Vec::new(), vec![(&root[..], shift)]);
        let (mut ids, mut ends) = (Vec::new(), Vec::new());
        for (place, tree) in pieces {
            roots.push((*place, tree.nodes[0].moved(shift)));
            nodes.push((&tree.nodes[1..], shift));
            ids.push((&tree.ids[..], ()));
            ends.push((&tree.ends[..], ids_in_front));
            shift = (shift.0 + tree.nodes.len() as u32 - 1, shift.1 + tree.ends.len() as u32);
            ids_in_front += tree.ids.len();
        }
        let mut tree = Self {
            nodes: parallel::concat(&nodes, &CollapsedNode::moved),
            ids: parallel::concat(&ids, &|id, ()| id),
            ends: parallel::concat(&ends, &|end, ids| end + ids),
        };
        // pieces come before those below them
        for (place, root) in roots.into_iter().rev() {
            tree.nodes[place] = root;
            if root.sum.is_none() {
                tree.order(place);
            }
        }
        tree
    }

    /// The tree of a subtree that is no leaf; those of its children at once, `forks` times one below
    /// the other.
    fn forked(collapse: &Collapse<'_>, root: u32, forks: u32) -> ForkedTree<Self> {
        let (mut tree, mut ids) = (Self::default(), Vec::new());
        tree.nodes.push(CollapsedNode::default());
        let mut waiting = vec![(0, root)];
        while let Some((number, subtree)) = waiting.pop() {
            tree.add_children(collapse, number, subtree, &mut waiting, &mut ids);
            if forks > 0 {
                break;
            }
        }
        if forks == 0 {
            (0..tree.nodes.len()).rev().for_each(|number| tree.order(number));
        }
        waiting.reverse();
        let below = |&(number, subtree): &(usize, u32)| {
            (number, Self::forked(collapse, subtree, forks - 1))
        };
        ForkedTree { piece: tree, below: parallel::map(&waiting, &below) }
    }

    /// Adds the children of a node; those that are no leaves are waiting then.
    fn add_children(
        &mut self,
        collapse: &Collapse<'_>,
        number: usize,
        subtree: u32,
        waiting: &mut Vec<(usize, u32)>,
        below: &mut Vec<u32>,
    ) {
        let (subtrees, n) = collapse.children(subtree);
        let mut children = [Child::default(); WIDTH];
        for (child, &subtree) in children.iter_mut().zip(&subtrees[..n]) {
            let half_area = collapse.bounds(subtree).half_area();
            let place = if collapse.is_leaf(subtree) {
                self.add_leaf(collapse, subtree, below);
                LEAF | (self.ends.len() - 1) as u32
            } else {
                waiting.push((self.nodes.len(), subtree));
                self.nodes.push(CollapsedNode::default());
                (self.nodes.len() - 1) as u32
            };
            *child = Child { subtree, place, half_area };
        }
        self.nodes[number] = CollapsedNode { children, number: n, sum: None };
    }

    fn add_leaf(&mut self, collapse: &Collapse<'_>, subtree: u32, below: &mut Vec<u32>) {
        collapse.ids(subtree, below, &mut self.ids);
        self.ends.push(self.ids.len());
    }

    /// Brings the children of a node into the order in which shadow rays ask them; nodes below it
    /// are in order.
    fn order(&mut self, number: usize) {
        let mut node = self.nodes[number];
        let mut sum = Areas { all: 0.0, leaves: 0.0 };
        let mut by_worth = [(0.0, Child::default()); WIDTH];
        for (slot, &child) in by_worth.iter_mut().zip(node.children()) {
            let (own, place) = (child.half_area, child.place);
            let leaf = Areas { all: own, leaves: own };
            let below = match place & LEAF {
                0 => self.nodes[place as usize].sum.map_or(leaf, |sum| sum.within(own)),
                _ => leaf,
            };
            sum.all += below.all;
            sum.leaves += below.leaves;
            *slot = (below.hits_per_cost(own), child);
        }
        by_worth[..node.number].sort_by(|(a, _), (b, _)| b.total_cmp(a));
        node.children = by_worth.map(|(_, child)| child);
        node.sum = Some(sum);
        self.nodes[number] = node;
    }

    /// The ids of each leaf.
    pub(super) fn leaves(&self) -> Vec<&[u32]> {
        let mut first = 0;
        let ids = |&end| &self.ids[std::mem::replace(&mut first, end)..end];
        self.ends.iter().map(ids).collect()
    }
}

/// Sums of half areas of boxes below a node.
#[derive(Clone, Copy)]
struct Areas {
    /// Of nodes and of leaves: what visits of rays cost.
    all: f32,
    leaves: f32,
}

impl Areas {
    /// These and that of the node itself.
    fn within(self, own: f32) -> Self {
        Self { all: self.all + own, ..self }
    }

    /// Hits of the rays that meet a child of this half area, over what they cost.
    fn hits_per_cost(self, own: f32) -> f32 {
        if self.all > 0.0 { self.leaves.min(own) / self.all } else { 1.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bvh::build::agglomerated::tests::scattered;
    use crate::bvh::build::binned;
    use crate::bvh::collapse::{Costs, LEVELS};
    use crate::bvh::items::Groups;

    /// What each child costs and hits, counted from the leaves up by itself.
    fn areas(tree: &CollapsedTree, collapse: &Collapse<'_>, child: &Child) -> Areas {
        let own = collapse.bounds(child.subtree).half_area();
        if child.place & LEAF != 0 {
            return Areas { all: own, leaves: own };
        }
        let children = tree.nodes[child.place as usize].children().iter();
        let below = children.map(|child| areas(tree, collapse, child));
        below.fold(Areas { all: own, leaves: 0.0 }, |sum, child| Areas {
            all: sum.all + child.all,
            leaves: sum.leaves + child.leaves,
        })
    }

    #[test]
    fn children_with_more_hits_for_their_cost_come_first() {
        let boxes = scattered(30_000, 0.02);
        let mut bvh = binned::tree(&boxes, 16);
        let costs = Costs { node: 1.0, longest_leaf: 16 };
        let collapse = Collapse::plan(&mut bvh, &Groups::Single, costs, LEVELS);
        let tree = CollapsedTree::of(&collapse);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().unwrap();
        let forked = pool.install(|| CollapsedTree::of(&collapse));
        let children = |tree: &CollapsedTree| {
            let of_node =
                |node: &CollapsedNode| node.children.map(|child| (child.subtree, child.place));
            tree.nodes.iter().map(of_node).collect::<Vec<_>>()
        };
        assert!(children(&tree) == children(&forked));
        let (mut moved, mut pairs) = (0, 0);
        let mut waiting = vec![(0, 0)];
        while let Some((place, subtree)) = waiting.pop() {
            if place & LEAF != 0 {
                continue;
            }
            let node = &tree.nodes[place as usize];
            waiting.extend(node.children().iter().map(|child| (child.place, child.subtree)));
            let (mut planned, n) = collapse.children(subtree);
            let mut subtrees: Vec<u32> =
                node.children().iter().map(|child| child.subtree).collect();
            moved += usize::from(planned[..n] != subtrees);
            planned[..n].sort_unstable();
            subtrees.sort_unstable();
            assert_eq!(planned[..n], subtrees);
            let worth = |child: &Child| {
                let own = collapse.bounds(child.subtree).half_area();
                f64::from(areas(&tree, &collapse, child).hits_per_cost(own))
            };
            let worths: Vec<f64> = node.children().iter().map(worth).collect();
            for pair in worths.windows(2) {
                // sums in another order
                assert!(pair[0] > pair[1] - 1e-4, "{worths:?}");
                pairs += usize::from(pair[0] > pair[1] + 1e-3);
            }
        }
        assert!(moved > 100 && pairs > 300, "{moved} {pairs}");
        let leaf = Areas { all: 2.0, leaves: 2.0 };
        assert_eq!(
            (leaf.hits_per_cost(2.0), Areas { all: 0.0, leaves: 0.0 }.hits_per_cost(0.0)),
            (1.0, 1.0)
        );
        // four times the node's own area in its leaves: a ray hits once
        assert_eq!(Areas { all: 10.0, leaves: 8.0 }.hits_per_cost(2.0), 0.2);
    }
}
