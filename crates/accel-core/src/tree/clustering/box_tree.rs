//! A binary tree over boxes, split at the median, from which boxes can be taken out.

use crate::geometry::aabb::Aabb;
use crate::geometry::scalar::{Scalar, Vector};
use crate::tree::median_cut::Centres;

/// Boxes a leaf holds at most.
const LEAF: usize = 4;

/// How two boxes have to lie to be neighbours.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NeighbourRule<S> {
    /// Largest distance on every axis; negative asks for an overlap.
    pub gap: S,
    /// A distance of exactly `gap` counts.
    pub closed: bool,
}

impl<S: Scalar> NeighbourRule<S> {
    /// True when `a` and `b` are neighbours.
    #[inline(always)]
    pub fn holds(&self, a: &Aabb<S>, b: &Aabb<S>) -> bool {
        let (a_lo, a_hi) = (a.min.to_array(), a.max.to_array());
        let (b_lo, b_hi) = (b.min.to_array(), b.max.to_array());
        (0..3).all(|k| {
            let (d, e) = (b_lo[k] - a_hi[k], a_lo[k] - b_hi[k]);
            if self.closed { d <= self.gap && e <= self.gap } else { d < self.gap && e < self.gap }
        })
    }
}

struct Node<S: Scalar> {
    /// Holds every box below, taken out or not.
    bounds: Aabb<S>,
    /// Boxes below that are still there.
    live: u32,
    /// The right child; the left one is the next node. Unused in leaves.
    right: u32,
}

/// The tree; boxes are named by their position in the slice it was made from.
pub struct BoxTree<'a, S: Scalar> {
    boxes: &'a [Aabb<S>],
    /// Leaf contents; those still there come first in each leaf.
    order: Vec<u32>,
    nodes: Vec<Node<S>>,
}

impl<'a, S: Scalar> BoxTree<'a, S> {
    /// Builds the tree in O(n log n).
    pub fn new(boxes: &'a [Aabb<S>]) -> Self {
        let order = (0..boxes.len() as u32).collect();
        let mut tree = Self { boxes, order, nodes: Vec::new() };
        if !boxes.is_empty() {
            tree.build(&Centres::of_boxes(boxes), 0, boxes.len());
        }
        tree
    }

    fn build(&mut self, centres: &Centres<S>, first: usize, last: usize) {
        let node = self.nodes.len();
        let items = &mut self.order[first..last];
        let bounds = items.iter().fold(Aabb::empty(), |all, &i| all.union(self.boxes[i as usize]));
        self.nodes.push(Node { bounds, live: (last - first) as u32, right: 0 });
        if last - first <= LEAF {
            return;
        }
        let middle = (last - first) / 2;
        centres.cut(items, middle);
        self.build(centres, first, first + middle);
        self.nodes[node].right = self.nodes.len() as u32;
        self.build(centres, first + middle, last);
    }

    /// Takes out every box near `query` and appends it to `taken`.
    pub fn take_near(&mut self, query: &Aabb<S>, near: &NeighbourRule<S>, taken: &mut Vec<u32>) {
        if !self.boxes.is_empty() {
            self.take(0, 0, self.boxes.len(), query, near, taken);
        }
    }

    fn take(
        &mut self,
        node: usize,
        first: usize,
        last: usize,
        query: &Aabb<S>,
        near: &NeighbourRule<S>,
        taken: &mut Vec<u32>,
    ) {
        if self.nodes[node].live == 0 || !near.holds(query, &self.nodes[node].bounds) {
            return;
        }
        let before = taken.len();
        if last - first <= LEAF {
            let mut live = self.nodes[node].live as usize;
            let mut i = 0;
            while i < live {
                let id = self.order[first + i];
                if near.holds(query, &self.boxes[id as usize]) {
                    taken.push(id);
                    live -= 1;
                    self.order.swap(first + i, first + live);
                } else {
                    i += 1;
                }
            }
        } else {
            let middle = first + (last - first) / 2;
            self.take(node + 1, first, middle, query, near, taken);
            self.take(self.nodes[node].right as usize, middle, last, query, near, taken);
        }
        self.nodes[node].live -= (taken.len() - before) as u32;
    }

    /// Calls `visit` with every box that holds `query`, borders included.
    pub fn holding(&self, query: &Aabb<S>, visit: &mut impl FnMut(u32)) {
        if !self.boxes.is_empty() {
            self.find_holding(0, 0, self.boxes.len(), query, visit);
        }
    }

    fn find_holding(
        &self,
        node: usize,
        first: usize,
        last: usize,
        query: &Aabb<S>,
        visit: &mut impl FnMut(u32),
    ) {
        if !holds(&self.nodes[node].bounds, query) {
            return;
        }
        if last - first <= LEAF {
            for &i in &self.order[first..last] {
                if holds(&self.boxes[i as usize], query) {
                    visit(i);
                }
            }
            return;
        }
        let middle = first + (last - first) / 2;
        self.find_holding(node + 1, first, middle, query, visit);
        self.find_holding(self.nodes[node].right as usize, middle, last, query, visit);
    }
}

/// True when `inner` lies within `outer`, borders included.
pub fn holds<S: Scalar>(outer: &Aabb<S>, inner: &Aabb<S>) -> bool {
    outer.union(*inner) == *outer
}
