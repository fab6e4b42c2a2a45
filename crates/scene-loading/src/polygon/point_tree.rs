//! Points of a plane in a balanced k-d tree (J. L. Bentley, "Multidimensional Binary Search Trees
//! Used for Associative Searching", 1975) that asks whether a triangle holds one, and forgets
//! points.
//!
//! Nodes keep tight boxes, so that clusters cost no more than even spread. Children are halves of a
//! list, found by arithmetic; nothing is linked.

use glam::DVec2;

/// The most points of a leaf.
const LEAF: usize = 4;

/// Marks a vertex that is not in the tree.
const NOWHERE: u32 = u32::MAX;

pub(super) struct PointTree {
    ids: Vec<u32>,
    /// Position in `ids` of each vertex of the polygon.
    slots: Vec<u32>,
    /// The children of node `k` are `2 k + 1` and `2 k + 2`.
    nodes: Vec<Node>,
}

#[derive(Clone, Copy)]
struct Node {
    min: DVec2,
    max: DVec2,
    /// Points that are left.
    live: u32,
}

/// A node and its part of the list.
#[derive(Clone, Copy)]
struct PendingNode {
    node: usize,
    from: usize,
    to: usize,
}

impl PendingNode {
    /// Both halves, unless it is a leaf.
    fn halves(self) -> Option<[Self; 2]> {
        let Self { node, from, to } = self;
        let middle = from.midpoint(to);
        (to - from > LEAF).then_some([
            Self { node: 2 * node + 1, from, to: middle },
            Self { node: 2 * node + 2, from: middle, to },
        ])
    }
}

impl PointTree {
    /// A tree of some of the points, named by their positions in the list.
    pub fn new(points: &[DVec2], ids: Vec<u32>) -> Self {
        let mut tree = Self { ids, slots: Vec::new(), nodes: Vec::new() };
        if !tree.ids.is_empty() {
            tree.slots = vec![NOWHERE; points.len()];
            tree.build(points, tree.root());
        }
        for (slot, &id) in tree.ids.iter().enumerate() {
            tree.slots[id as usize] = slot as u32;
        }
        tree
    }

    fn root(&self) -> PendingNode {
        PendingNode { node: 0, from: 0, to: self.ids.len() }
    }

    fn build(&mut self, points: &[DVec2], part: PendingNode) {
        let ids = &mut self.ids[part.from..part.to];
        let (mut min, mut max) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        for &id in ids.iter() {
            min = min.min(points[id as usize]);
            max = max.max(points[id as usize]);
        }
        let node = Node { min, max, live: ids.len() as u32 };
        let empty = Node { live: 0, ..node };
        self.nodes.resize(self.nodes.len().max(part.node + 1), empty);
        self.nodes[part.node] = node;
        let Some(halves) = part.halves() else { return };
        let axis = (max - min).max_position();
        let order =
            |a: &u32, b: &u32| points[*a as usize][axis].total_cmp(&points[*b as usize][axis]);
        ids.select_nth_unstable_by(halves[0].to - part.from, order);
        halves.into_iter().for_each(|half| self.build(points, half));
    }

    /// Returns whether a vertex is in the tree.
    pub fn has(&self, id: usize) -> bool {
        self.slots.get(id).is_some_and(|&slot| slot != NOWHERE)
    }

    /// Takes a vertex out.
    pub fn remove(&mut self, id: usize) {
        let Some(slot) = self.slots.get_mut(id).filter(|slot| **slot != NOWHERE) else { return };
        let slot = std::mem::replace(slot, NOWHERE) as usize;
        let mut part = self.root();
        loop {
            self.nodes[part.node].live -= 1;
            let Some([low, high]) = part.halves() else { return };
            part = if slot < low.to { low } else { high };
        }
    }

    /// Whether `holds` is true for a vertex within the triangle `a`, `b`, `c`, which runs against
    /// the clock. `steps` counts the nodes and vertices looked at.
    pub fn any_within(
        &self,
        corners: [DVec2; 3],
        holds: &impl Fn(usize) -> bool,
        steps: &mut u64,
    ) -> bool {
        !self.nodes.is_empty() && self.search(self.root(), corners, holds, steps)
    }

    fn search(
        &self,
        part: PendingNode,
        corners: [DVec2; 3],
        holds: &impl Fn(usize) -> bool,
        steps: &mut u64,
    ) -> bool {
        *steps += 1;
        let node = &self.nodes[part.node];
        if node.live == 0 || is_beside(node, corners) {
            return false;
        }
        if let Some(halves) = part.halves() {
            return halves.into_iter().any(|half| self.search(half, corners, holds, steps));
        }
        let ids = &self.ids[part.from..part.to];
        *steps += ids.len() as u64;
        ids.iter().any(|&id| self.has(id as usize) && holds(id as usize))
    }
}

/// True when the whole box of a node is on the outer side of an edge of the triangle. (Rounded
/// orientations are monotonic in each coordinate, so that no point of the box is misjudged.)
fn is_beside(node: &Node, [a, b, c]: [DVec2; 3]) -> bool {
    [(a, b), (b, c), (c, a)].into_iter().any(|(from, to)| {
        // the corner of the box that lies furthest on the inner side
        let x = if to.y - from.y > 0.0 { node.min.x } else { node.max.x };
        let y = if to.x - from.x > 0.0 { node.max.y } else { node.min.y };
        orientation(from, to, DVec2::new(x, y)) < 0.0
    })
}

/// Positive when the three points turn to the left: twice the triangle's area.
pub(super) fn orientation(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    (b - a).perp_dot(c - a)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tree_finds_the_same_points_as_a_linear_search() {
        let mut state = 7_u64;
        let mut random = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (state >> 40) as f64 / f64::from(1 << 24)
        };
        // half of them in a cluster, some equal
        let points: Vec<DVec2> = (0..1000)
            .map(|i| {
                let scale = if i % 2 == 0 { 1.0 } else { 1e-3 };
                DVec2::new((random() * 64.0).floor() / 64.0, random()) * scale
            })
            .collect();
        let mut tree = PointTree::new(&points, (0..1000).filter(|i| i % 3 != 0).collect());
        let mut found = 0;
        for round in 0..999 {
            let mut corners = [0; 3].map(|_| DVec2::new(random(), random()) * 0.1);
            if orientation(corners[0], corners[1], corners[2]) < 0.0 {
                corners.swap(0, 1);
            }
            let [a, b, c] = corners;
            let holds = |i: usize| {
                let p = points[i];
                [(a, b), (b, c), (c, a)].iter().all(|&(from, to)| orientation(from, to, p) >= 0.0)
            };
            let expected = (0..1000).any(|i| tree.has(i) && holds(i));
            let mut steps = 0;
            assert_eq!(tree.any_within(corners, &holds, &mut steps), expected, "{round}");
            assert!(steps > 0);
            found += usize::from(expected);
            tree.remove(round);
            assert!(!tree.has(round));
        }
        assert!(found > 50, "{found}");
        let mut none = 0;
        assert!(!PointTree::new(&[], vec![]).any_within([DVec2::ZERO; 3], &|_| true, &mut none));
    }
}
