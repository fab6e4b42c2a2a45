//! The eight-wide nodes and the leaves that a planned collapse makes, numbered.

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
        let (mut roots, mut nodes) = (Vec::new(), vec![(&[CollapsedNode::NONE][..], shift)]);
        let (mut ids, mut ends) = (Vec::new(), Vec::new());
        for (place, tree) in pieces {
            roots.push((*place, tree.nodes[0].moved(shift)));
            nodes.push((&tree.nodes[1..], shift));
            ids.push((&tree.ids[..], ()));
            ends.push((&tree.ends[..], ids_in_front));
            shift = (shift.0 + tree.nodes.len() as u32 - 1, shift.1 + tree.ends.len() as u32);
            ids_in_front += tree.ids.len();
        }
        let mut nodes = parallel::concat(&nodes, &CollapsedNode::moved);
        roots.into_iter().for_each(|(place, root)| nodes[place] = root);
        Self {
            nodes,
            ids: parallel::concat(&ids, &|id, ()| id),
            ends: parallel::concat(&ends, &|end, ids| end + ids),
        }
    }

    /// The tree of a subtree that is no leaf; those of its children at once, `forks` times one below
    /// the other.
    fn forked(collapse: &Collapse<'_>, root: u32, forks: u32) -> ForkedTree<Self> {
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
