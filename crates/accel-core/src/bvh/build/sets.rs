//! From a set of boxes to the nodes of a tree, by one cut after the other.

use obvhs::aabb::Aabb;
use obvhs::bvh2::node::Bvh2Node;

use super::boxes::{Item, SetBounds};
use super::cut::{BinSplit, Bins};
use crate::parallel::{self, ForkedTree};

/// Levels below which sets are halved in the order of their numbers: with those of a balanced tree a
/// stack of obvhs has room for them.
pub(super) const MOST_CUTS: u32 = 48;

/// Nodes of a tree: its root, then pairs of siblings, those below the lower one before those below
/// the upper one.
pub(super) struct Nodes {
    pub(super) all: Vec<Bvh2Node>,
    /// Places of those below the root that are of many items, and of how many.
    pub(super) upper: Vec<(u32, u32)>,
}

impl Nodes {
    /// A root that is not made yet, and room for so many nodes.
    pub(super) fn with_root(room: usize) -> Self {
        let mut all = Vec::with_capacity(room);
        all.push(Bvh2Node::new(Aabb::default(), 1, 0));
        Self { all, upper: Vec::new() }
    }

    /// These nodes with others behind them, on all threads. Of each of those, which begin with a
    /// root that is none of them or the only one, the roots come to places of all nodes.
    pub(super) fn grafted(self, others: Vec<(Vec<(usize, Bvh2Node)>, Self)>) -> Self {
        let moved = |mut node: Bvh2Node, by: u32| {
            if !node.is_leaf() {
                node.first_index += by;
            }
            node
        };
        let (mut upper, mut roots) = (self.upper, Vec::new());
        let (mut pieces, mut next) = (vec![(&self.all[..], 0)], self.all.len());
        for (own_roots, below) in &others {
            // the first pair of the others is at 1
            let shift = next as u32 - 1;
            roots.extend(own_roots.iter().map(|&(place, root)| (place, moved(root, shift))));
            upper.extend(below.upper.iter().map(|(place, items)| (place + shift, *items)));
            pieces.push((&below.all[1..], shift));
            next += below.all.len() - 1;
        }
        let mut all = parallel::concat(&pieces, &moved);
        roots.into_iter().for_each(|(place, root)| all[place] = root);
        Self { all, upper }
    }
}

/// Places of the nodes that are of more items than this.
pub(super) fn larger_than(nodes: &[(u32, u32)], items: usize) -> Vec<u32> {
    nodes.iter().filter(|(_, own)| *own as usize > items).map(|(place, _)| *place).collect()
}

/// Thresholds of small and large sets.
#[derive(Clone, Copy)]
pub(super) struct Sizes {
    /// So many are a leaf.
    pub(super) few: usize,
    /// Nodes of more items are upper ones.
    pub(super) upper_above: usize,
    /// Sets may be divided by several threads, so that the order of their items is nobody's.
    pub(super) is_parallel: bool,
}

/// Items that a node is to be made of, at least one.
pub(super) struct Set<'a> {
    pub(super) items: &'a mut [Item],
    /// The place of the first.
    pub(super) first: usize,
    pub(super) around: SetBounds,
    pub(super) level: u32,
    /// The place of the node.
    pub(super) node: u32,
}

impl Set<'_> {
    /// The tree of these items, the set being the root; on all threads.
    pub(super) fn tree(self, sizes: Sizes) -> Nodes {
        let forked = self.forked(sizes, parallel::forks());
        if forked.below.is_empty() {
            return forked.piece;
        }
        let pieces = forked.pieces(|nodes| nodes.all.len()).into_iter();
        let grafts = pieces.map(|(place, nodes)| (vec![(place, nodes.all[0])], nodes));
        Nodes::with_root(1).grafted(grafts.collect())
    }

    /// Both sides at once, `forks` times one below the other.
    fn forked(self, sizes: Sizes, forks: u32) -> ForkedTree<Nodes> {
        let n = self.items.len();
        let is_alone = forks == 0 || !parallel::should_parallelize(n);
        let room = if is_alone { 2 * n } else { 3 };
        let (mut nodes, mut bins) = (Nodes::with_root(room), Bins::NONE);
        let root = Set { node: 0, ..self };
        if is_alone {
            root.build(&mut nodes, &mut bins, sizes);
            return ForkedTree { piece: nodes, below: Vec::new() };
        }
        let Some(sides) = root.divided(&mut nodes, sizes, &mut bins) else {
            return ForkedTree { piece: nodes, below: Vec::new() };
        };
        let places = [0, 1].map(|k| sides[k].node as usize);
        let [a, b] = sides;
        let (a, b) = rayon::join(|| a.forked(sizes, forks - 1), || b.forked(sizes, forks - 1));
        ForkedTree { piece: nodes, below: vec![(places[0], a), (places[1], b)] }
    }

    /// Makes the node and all below it.
    pub(super) fn build(self, nodes: &mut Nodes, bins: &mut Bins, sizes: Sizes) {
        let (mut next, mut waiting) = (Some(self), Vec::new());
        while let Some(set) = next {
            next = match set.divided(nodes, sizes, bins) {
                Some([lower, upper]) => {
                    waiting.push(upper);
                    Some(lower)
                }
                None => waiting.pop(),
            };
        }
    }

    /// Makes the node, and gives both sides of the cut that costs least; none of a leaf.
    #[inline(always)]
    fn divided(self, nodes: &mut Nodes, sizes: Sizes, bins: &mut Bins) -> Option<[Self; 2]> {
        let Self { items, first, around, level, node } = self;
        let (bounds, n, pair) = (around.items.aabb(), items.len(), nodes.all.len() as u32);
        if n <= sizes.few {
            if sizes.is_parallel {
                items.sort_unstable_by_key(Item::number);
            }
            nodes.all[node as usize] = Bvh2Node::new(bounds, n as u32, first as u32);
            return None;
        }
        let inner = Bvh2Node::new(bounds, 0, pair);
        nodes.all[node as usize] = inner;
        nodes.all.extend([inner; 2]);
        let cut = match level {
            ..=MOST_CUTS => BinSplit::of(items, &around.centres, bins),
            _ => None,
        };
        let (middle, [lower, upper]) = match cut {
            Some(cut) => cut.partition(items),
            None => {
                items.sort_unstable_by_key(Item::number);
                (n / 2, [SetBounds::of(&items[..n / 2]), SetBounds::of(&items[n / 2..])])
            }
        };
        let (lower_items, upper_items) = items.split_at_mut(middle);
        let level = level + 1;
        let sides = [
            Set { items: lower_items, first, around: lower, level, node: pair },
            Set { items: upper_items, first: first + middle, around: upper, level, node: pair + 1 },
        ];
        let many = sides.iter().filter(|set| set.items.len() > sizes.upper_above);
        nodes.upper.extend(many.map(|set| (set.node, set.items.len() as u32)));
        Some(sides)
    }
}
