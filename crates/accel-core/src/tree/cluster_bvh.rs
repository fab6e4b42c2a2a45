//! A binary hierarchy of boxes over clusters and single primitives.
//!
//! Idea: a surface-area hierarchy (J. Goldsmith, J. Salmon, "Automatic Creation of Object
//! Hierarchies for Ray Tracing", IEEE CG&A 7(5), 1987). Deviation: built from the top by a sweep
//! over sorted centres on each axis, each item at its cost; below a depth of 40 by halving, so
//! that the depth has a limit.

use std::ops::ControlFlow;

use crate::geometry::aabb::Aabb;
use crate::geometry::ray::Ray;
use crate::geometry::scalar::{Scalar, Vector};
use crate::query::sink::Sink;

/// A leaf: a cluster's grid, or a primitive without cluster.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Item {
    /// Number of a grid.
    Grid(u32),
    Orphan(u32),
}

/// Depth from which halves are made.
const BALANCED_FROM: usize = 40;

/// Room for one waiting node per level: 40 levels and the logarithm of the largest number of items.
const STACK: usize = BALANCED_FROM + 34;

#[derive(Debug, Clone, Copy)]
struct Node<S: Scalar> {
    bounds: Aabb<S>,
    content: Content,
}

#[derive(Debug, Clone, Copy)]
enum Content {
    /// The left child is the next node, the right one this.
    Inner(u32),
    Leaf(Item),
}

/// The hierarchy; node 0 is the root.
pub(crate) struct ClusterBvh<S: Scalar> {
    nodes: Vec<Node<S>>,
}

impl<S: Scalar> ClusterBvh<S> {
    /// Builds it over items with their boxes.
    pub(crate) fn new(mut items: Vec<(Item, Aabb<S>)>) -> Self {
        let mut this = Self { nodes: Vec::with_capacity(2 * items.len()) };
        if !items.is_empty() {
            let mut areas = Vec::new();
            this.build(&mut items, 0, &mut areas);
        }
        this
    }

    fn build(&mut self, items: &mut [(Item, Aabb<S>)], depth: usize, areas: &mut Vec<f64>) {
        let number = self.nodes.len();
        let bounds = items.iter().fold(Aabb::empty(), |all, i| all.union(i.1));
        if let [(item, _)] = items {
            self.nodes.push(Node { bounds, content: Content::Leaf(*item) });
            return;
        }
        self.nodes.push(Node { bounds, content: Content::Inner(0) });
        let middle = items.len() / 2;
        let (axis, split) =
            if depth >= BALANCED_FROM { (0, middle) } else { best_split(items, areas) };
        sort(items, axis);
        let (left, right) = items.split_at_mut(split.clamp(1, items.len() - 1));
        self.build(left, depth + 1, areas);
        self.nodes[number].content = Content::Inner(self.nodes.len() as u32);
        self.build(right, depth + 1, areas);
    }

    pub(crate) fn inner_nodes(&self) -> u64 {
        self.nodes.iter().filter(|n| matches!(n.content, Content::Inner(_))).count() as u64
    }

    /// Inner nodes with a primitive right below them.
    pub(crate) fn inner_nodes_with_orphans(&self) -> u64 {
        let is_orphan = |n: usize| {
            let content = self.nodes.get(n).map(|node| node.content);
            matches!(content, Some(Content::Leaf(Item::Orphan(_))))
        };
        let has_orphan = |(n, node): (usize, &Node<S>)| match node.content {
            Content::Inner(right) => is_orphan(n + 1) || is_orphan(right as usize),
            Content::Leaf(_) => false,
        };
        self.nodes.iter().enumerate().filter(|&at| has_orphan(at)).count() as u64
    }

    /// Calls `each` with the box, the depth and the item, if any, of every node: a node before
    /// those below.
    pub(crate) fn visit(&self, each: &mut impl FnMut(Aabb<S>, u32, Option<Item>)) {
        let mut waiting = vec![(0, 0)];
        while let Some((number, depth)) = waiting.pop() {
            let Some(node) = self.nodes.get(number) else { continue };
            match node.content {
                Content::Leaf(item) => each(node.bounds, depth, Some(item)),
                Content::Inner(right) => {
                    each(node.bounds, depth, None);
                    waiting.extend([(right as usize, depth + 1), (number + 1, depth + 1)]);
                }
            }
        }
    }

    pub(crate) fn bytes(&self) -> u64 {
        size_of_val(self.nodes.as_slice()) as u64
    }

    /// Visits the items whose boxes the ray meets in `[t_start, sink.t_max()]`, near ones first.
    /// `on_node` is called for every inner node entered.
    #[inline(always)]
    pub(crate) fn traverse<K: Sink<S>>(
        &self,
        ray: &Ray<S>,
        t_start: S,
        sink: &mut K,
        mut on_node: impl FnMut(),
        mut visit: impl FnMut(Item, &mut K) -> ControlFlow<()>,
    ) {
        let enter = |node: usize, t_max: S| {
            let b = &self.nodes.get(node)?.bounds;
            b.clip(ray.origin, ray.direction, t_start, t_max).map(|(t, _)| t)
        };
        let mut stack = [(0u32, S::ZERO); STACK];
        let mut waiting = 0;
        let mut node = 0usize;
        if enter(node, sink.t_max()).is_none() {
            return;
        }
        loop {
            match self.nodes.get(node).map(|n| n.content) {
                Some(Content::Inner(right)) => {
                    sink.inner_step();
                    on_node();
                    let pair = [node + 1, right as usize];
                    let t = pair.map(|n| enter(n, sink.t_max()));
                    let (near, far) = match (t[0], t[1]) {
                        (Some(a), Some(b)) if b < a => (Some(pair[1]), Some((pair[0], a))),
                        (Some(_), Some(b)) => (Some(pair[0]), Some((pair[1], b))),
                        (Some(_), None) => (Some(pair[0]), None),
                        (None, Some(_)) => (Some(pair[1]), None),
                        (None, None) => (None, None),
                    };
                    if let (Some((far, t)), Some(slot)) = (far, stack.get_mut(waiting)) {
                        *slot = (far as u32, t);
                        waiting += 1;
                    }
                    if let Some(near) = near {
                        node = near;
                        continue;
                    }
                }
                Some(Content::Leaf(item)) => {
                    if visit(item, sink).is_break() {
                        return;
                    }
                }
                None => return,
            }
            loop {
                if waiting == 0 {
                    return;
                }
                waiting -= 1;
                if stack[waiting].1 <= sink.t_max() {
                    node = stack[waiting].0 as usize;
                    break;
                }
            }
        }
    }
}

fn centre<S: Scalar>(b: &Aabb<S>, k: usize) -> f64 {
    0.5 * b.min.to_array()[k].to_f64() + 0.5 * b.max.to_array()[k].to_f64()
}

/// By centre; equal ones in the order of their items.
fn sort<S: Scalar>(items: &mut [(Item, Aabb<S>)], axis: usize) {
    let name = |i: Item| match i {
        Item::Grid(g) => (0, g),
        Item::Orphan(id) => (1, id),
    };
    items.sort_unstable_by(|a, b| {
        let order = centre(&a.1, axis).total_cmp(&centre(&b.1, axis));
        order.then_with(|| name(a.0).cmp(&name(b.0)))
    });
}

/// The axis and number of items on the left with the least sum of surface times items.
fn best_split<S: Scalar>(items: &mut [(Item, Aabb<S>)], areas: &mut Vec<f64>) -> (usize, usize) {
    let n = items.len();
    let mut best = (f64::INFINITY, 0, n / 2);
    for axis in 0..3 {
        sort(items, axis);
        areas.clear();
        let mut all = Aabb::empty();
        areas.extend(items.iter().map(|i| {
            all = all.union(i.1);
            all.half_area()
        }));
        let mut right = Aabb::empty();
        for split in (1..n).rev() {
            right = right.union(items[split].1);
            let cost = areas[split - 1] * split as f64 + right.half_area() * (n - split) as f64;
            if cost < best.0 {
                best = (cost, axis, split);
            }
        }
    }
    (best.1, best.2)
}
