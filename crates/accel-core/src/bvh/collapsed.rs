//! The eight-wide nodes and the leaves that a planned collapse makes, numbered.

use super::collapse::{Collapse, LEAF, WIDTH};
use crate::parallel;

/// The nodes of the collapsed tree, the first its root, none if that is a leaf; children come after
/// their parents.
#[derive(Default)]
pub(super) struct CollapsedTree {
    pub(super) nodes: Vec<CollapsedNode>,
    /// The ids of all leaves, one after the other, and where each ends.
    ids: Vec<u32>,
    ends: Vec<usize>,
}

/// A node that is no leaf.
#[derive(Clone, Copy)]
pub(super) struct CollapsedNode {
    /// The subtrees that became its children, so many.
    subtrees: [u32; WIDTH],
    /// Node numbers, or leaf numbers with [`LEAF`].
    places: [u32; WIDTH],
    children: usize,
}

impl CollapsedNode {
    const NONE: Self = Self { subtrees: [0; WIDTH], places: [0; WIDTH], children: 0 };

    /// Its children: of each the subtree and which node or leaf it is.
    pub(super) fn children(&self) -> impl Iterator<Item = (u32, u32)> {
        self.subtrees.into_iter().zip(self.places).take(self.children)
    }

    /// The same node where the numbers of nodes and of leaves are larger by so much.
    fn moved(mut self, (nodes, leaves): (u32, u32)) -> Self {
        for place in &mut self.places[..self.children] {
            *place += if *place & LEAF == 0 { nodes } else { leaves };
        }
        self
    }
}

/// A tree of which some nodes are the roots of others, that other threads made.
struct ForkedTree {
    tree: CollapsedTree,
    /// Behind its own nodes, in this order, come those below these nodes.
    below: Vec<(usize, Self)>,
}

/// A tree without its root in the order of all nodes.
struct Graft {
    /// The place of its root.
    root: usize,
    tree: CollapsedTree,
    /// Nodes, leaves and ids in front of it; of its own nodes the first is the root.
    in_front: [usize; 3],
}

impl ForkedTree {
    /// Adds the tree whose root is in that place and all below it.
    fn graft(self, root: usize, next: &mut [usize; 3], grafts: &mut Vec<Graft>) {
        let in_front = *next;
        let own = [self.tree.nodes.len() - 1, self.tree.ends.len(), self.tree.ids.len()];
        next.iter_mut().zip(own).for_each(|(next, own)| *next += own);
        grafts.push(Graft { root, tree: self.tree, in_front });
        self.below.into_iter().for_each(|(at, below)| below.graft(at + in_front[0], next, grafts));
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
            return Self::forked(collapse, 0, 0).tree;
        }
        // a level of eight-wide nodes is three of binary ones
        let forked = Self::forked(collapse, 0, parallel::forks().div_ceil(3));
        let mut grafts = Vec::new();
        forked.graft(0, &mut [0; 3], &mut grafts);
        Self::joined(&grafts)
    }

    fn joined(grafts: &[Graft]) -> Self {
        let shift = |graft: &Graft| (graft.in_front[0] as u32, graft.in_front[1] as u32);
        let nodes = grafts.iter().map(|graft| (&graft.tree.nodes[1..], shift(graft)));
        let root = (&[CollapsedNode::NONE][..], (0, 0));
        let nodes: Vec<_> = std::iter::once(root).chain(nodes).collect();
        let mut nodes = parallel::concat(&nodes, &CollapsedNode::moved);
        for graft in grafts {
            nodes[graft.root] = graft.tree.nodes[0].moved(shift(graft));
        }
        let ids: Vec<_> = grafts.iter().map(|graft| (&graft.tree.ids[..], ())).collect();
        let ends = grafts.iter().map(|graft| (&graft.tree.ends[..], graft.in_front[2]));
        let ends: Vec<_> = ends.collect();
        Self {
            nodes,
            ids: parallel::concat(&ids, &|id, ()| id),
            ends: parallel::concat(&ends, &|end, ids| end + ids),
        }
    }

    /// The tree of a subtree that is no leaf; those of its children at once, `forks` times one below
    /// the other.
    fn forked(collapse: &Collapse<'_>, root: u32, forks: u32) -> ForkedTree {
        let (mut tree, mut ids) = (Self::default(), Vec::new());
        tree.nodes.push(CollapsedNode::NONE);
        let mut waiting = vec![(0, root)];
        while let Some((number, subtree)) = waiting.pop() {
            tree.add_children(collapse, number, subtree, &mut waiting, &mut ids);
            if forks > 0 {
                break;
            }
        }
        waiting.reverse();
        let below = |&(number, subtree): &(usize, u32)| {
            (number, Self::forked(collapse, subtree, forks - 1))
        };
        ForkedTree { tree, below: parallel::map(&waiting, &below) }
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
        let mut places = [0; WIDTH];
        for (place, &child) in places.iter_mut().zip(&subtrees[..n]) {
            if collapse.is_leaf(child) {
                *place = LEAF | self.ends.len() as u32;
                self.add_leaf(collapse, child, below);
            } else {
                *place = self.nodes.len() as u32;
                waiting.push((self.nodes.len(), child));
                self.nodes.push(CollapsedNode::NONE);
            }
        }
        self.nodes[number] = CollapsedNode { subtrees, places, children: n };
    }

    fn add_leaf(&mut self, collapse: &Collapse<'_>, subtree: u32, below: &mut Vec<u32>) {
        collapse.ids(subtree, below, &mut self.ids);
        self.ends.push(self.ids.len());
    }

    /// The ids of each leaf.
    pub(super) fn leaves(&self) -> Vec<&[u32]> {
        let mut first = 0;
        let ids = |&end| &self.ids[std::mem::replace(&mut first, end)..end];
        self.ends.iter().map(ids).collect()
    }
}
