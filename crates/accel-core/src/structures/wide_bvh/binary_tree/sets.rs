//! From a set of boxes to the nodes of a tree, by one cut after the other.

use obvhs::aabb::Aabb;
use obvhs::bvh2::node::Bvh2Node;

use super::boxes::{Around, Item};
use super::cut::{Bins, Cut};
use crate::parallel;

/// Levels below which sets are halved as they lie: with those of a balanced tree a stack of obvhs has room for them.
pub(super) const MOST_CUTS: u32 = 48;

/// Nodes of a tree: its root, then pairs of siblings, those below the lower one before those below the upper one.
pub(super) struct Nodes {
    pub(super) all: Vec<Bvh2Node>,
    /// Places of those below the root that are of many items.
    pub(super) upper: Vec<u32>,
}

impl Nodes {
    /// A root that is not made yet, and room for so many nodes.
    pub(super) fn with_root(room: usize) -> Self {
        let mut all = Vec::with_capacity(room);
        all.push(Bvh2Node::new(Aabb::default(), 1, 0));
        Self { all, upper: Vec::new() }
    }

    /// Puts roots where nodes are, and what is below them behind all nodes. `below` begins with a root that is none of
    /// these, or the only one.
    pub(super) fn graft(&mut self, roots: &[(usize, Bvh2Node)], below: Self) {
        // the first pair of the others is at 1
        let shift = self.all.len() as u32 - 1;
        let moved = |mut node: Bvh2Node| {
            if !node.is_leaf() {
                node.first_index += shift;
            }
            node
        };
        for &(place, root) in roots {
            self.all[place] = moved(root);
        }
        self.all.extend(below.all.into_iter().skip(1).map(moved));
        self.upper.extend(below.upper.into_iter().map(|place| place + shift));
    }
}

/// How many items are few, and how many are many.
#[derive(Clone, Copy)]
pub(super) struct Sizes {
    /// So many are a leaf.
    pub(super) few: usize,
    /// The nodes of more are those which are inserted anew.
    pub(super) many: usize,
}

/// Items that a node is to be made of, at least one.
pub(super) struct Set<'a> {
    pub(super) items: &'a mut [Item],
    /// The place of the first.
    pub(super) first: usize,
    pub(super) around: Around,
    pub(super) level: u32,
    /// The place of the node.
    pub(super) node: usize,
}

impl Set<'_> {
    /// Makes the node and all below it.
    pub(super) fn build(self, nodes: &mut Nodes, bins: &mut Bins, sizes: Sizes, forks: u32) {
        let mut waiting = vec![self];
        while let Some(set) = waiting.pop() {
            let n = set.items.len();
            let Some(sides) = set.divided(nodes, sizes.few, bins) else { continue };
            let many = sides.iter().filter(|set| set.items.len() > sizes.many);
            nodes.upper.extend(many.map(|set| set.node as u32));
            let [a, b] = sides;
            if forks > 0 && parallel::is_worth_a_fork(n) {
                let places = [a.node, b.node];
                let apart = |set: Set<'_>| {
                    let (mut nodes, mut bins) = (Nodes::with_root(set.items.len()), Bins::NONE);
                    Set { node: 0, ..set }.build(&mut nodes, &mut bins, sizes, forks - 1);
                    nodes
                };
                let (a, b) = rayon::join(|| apart(a), || apart(b));
                nodes.graft(&[(places[0], a.all[0])], a);
                nodes.graft(&[(places[1], b.all[0])], b);
            } else {
                waiting.extend([b, a]);
            }
        }
    }

    /// Makes the node, and gives both sides of the cut that costs least; none of a leaf.
    fn divided(self, nodes: &mut Nodes, few: usize, bins: &mut Bins) -> Option<[Self; 2]> {
        let Self { items, first, around, level, node } = self;
        let (bounds, n, pair) = (around.items.aabb(), items.len(), nodes.all.len());
        if n <= few {
            nodes.all[node] = Bvh2Node::new(bounds, n as u32, first as u32);
            return None;
        }
        nodes.all[node] = Bvh2Node::new(bounds, 0, pair as u32);
        nodes.all.extend([nodes.all[node]; 2]);
        let cut = match level {
            ..=MOST_CUTS => Cut::of(items, &around.centres, bins),
            _ => None,
        };
        let (middle, [lower, upper]) = match cut {
            Some(cut) => cut.partition(items),
            None => (n / 2, [Around::of(&items[..n / 2]), Around::of(&items[n / 2..])]),
        };
        let (lower_items, upper_items) = items.split_at_mut(middle);
        let level = level + 1;
        Some([
            Set { items: lower_items, first, around: lower, level, node: pair },
            Set { items: upper_items, first: first + middle, around: upper, level, node: pair + 1 },
        ])
    }
}
