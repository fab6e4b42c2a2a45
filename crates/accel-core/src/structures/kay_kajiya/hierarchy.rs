//! The hierarchy: built from the top by median cuts, traversed nearest entry first.

use super::config::KayKajiyaConfig;
use crate::geometry::ray::Ray;
use crate::geometry::scalar::Scalar;
use crate::historical::bounds_rule::BoundsOf;
use crate::params::config::Settings;
use crate::primitives::PrimSet;
use crate::query::cells::{Cell, CellVisitor};
use crate::query::sink::Sink;
use crate::structure::{BuildError, StructureStats};
use crate::structures::bounding_volumes::check_cells;
use crate::structures::bounding_volumes::median_cut::Centres;
use crate::structures::bounding_volumes::slabs::Slabs;
use crate::structures::bounding_volumes::volume::Volume;
use crate::structures::kay_kajiya::entry_queue::EntryQueue;

/// A volume and what it holds.
#[derive(Debug, Clone, Copy)]
struct Node<S, const K: usize> {
    volume: Slabs<S, K>,
    content: Content,
}

/// What a node holds, as a range.
#[derive(Debug, Clone, Copy)]
enum Content {
    /// Of nodes.
    Inner { first: u32, count: u32 },
    /// Of places in the list of ids.
    Leaf { first: u32, count: u32 },
}

/// Volumes of `K` slabs; node 0 is the root, children come after their parents.
pub(super) struct Hierarchy<S, const K: usize> {
    nodes: Vec<Node<S, K>>,
    ids: Vec<u32>,
}

impl<S: Scalar, const K: usize> Hierarchy<S, K> {
    /// Builds it over all primitives.
    pub(super) fn new<P: PrimSet<S>>(
        boxes: &BoundsOf<S, P>,
        settings: &Settings<KayKajiyaConfig>,
    ) -> Result<Self, BuildError> {
        let mut ids: Vec<u32> = (0..boxes.prims().len() as u32).collect();
        let contents = cut_to_leaves(&mut ids, &Centres::of(boxes.prims()), settings)?;
        let nodes =
            contents.into_iter().map(|content| Node { volume: Slabs::empty(), content }).collect();
        let mut this = Self { nodes, ids };
        this.bound(boxes);
        Ok(this)
    }

    /// Makes the volumes, children before parents.
    fn bound<P: PrimSet<S>>(&mut self, boxes: &BoundsOf<S, P>) {
        for number in (0..self.nodes.len()).rev() {
            let volume = match self.nodes[number].content {
                Content::Inner { first, count } => self.nodes[range(first, count)]
                    .iter()
                    .fold(Slabs::empty(), |all, child| all.union(&child.volume)),
                Content::Leaf { first, count } => {
                    Slabs::around(&self.ids[range(first, count)], boxes)
                }
            };
            self.nodes[number].volume = volume;
        }
    }

    /// Visits the volumes in the order in which the ray enters them, until the next one is entered
    /// beyond the nearest hit.
    pub(super) fn traverse<T: Sink<S>>(&self, ray: &Ray<S>, sink: &mut T) {
        let setup = Slabs::<S, K>::setup(ray);
        let mut queue = EntryQueue::new();
        let enter = |number: u32, node: &Node<S, K>, queue: &mut EntryQueue<S>, t_max: S| {
            if let Some(t) = node.volume.entry(&setup, ray.t_min, t_max) {
                queue.push((t, number));
            }
        };
        enter(0, &self.nodes[0], &mut queue, sink.t_max());
        while let Some((t, number)) = queue.pop() {
            if t > sink.t_max() {
                return;
            }
            match self.nodes[number as usize].content {
                Content::Inner { first, count } => {
                    sink.inner_step();
                    for (number, node) in (first..).zip(&self.nodes[range(first, count)]) {
                        enter(number, node, &mut queue, sink.t_max());
                    }
                }
                Content::Leaf { first, count } => {
                    sink.elementary_step(false);
                    if sink.test(&self.ids[range(first, count)]).is_break() {
                        return;
                    }
                }
            }
        }
    }

    /// The primitives of each leaf.
    pub(super) fn lists(&self) -> impl Iterator<Item = &[u32]> {
        self.nodes.iter().filter_map(|node| match node.content {
            Content::Leaf { first, count } => Some(&self.ids[range(first, count)]),
            Content::Inner { .. } => None,
        })
    }

    /// Calls `each` with every node.
    pub(super) fn show(&self, each: &mut CellVisitor<'_>) {
        let mut waiting = vec![(0, 0)];
        while let Some((number, depth)) = waiting.pop() {
            let node = &self.nodes[number];
            let bounds = node.volume.bounds();
            match node.content {
                Content::Inner { first, count } => {
                    each(Cell::inner(bounds, depth));
                    waiting.extend(range(first, count).rev().map(|child| (child, depth + 1)));
                }
                Content::Leaf { first, count } => {
                    each(Cell::elementary(bounds, depth, &self.ids[range(first, count)]));
                }
            }
        }
    }

    /// What was built.
    pub(super) fn stats(&self) -> StructureStats {
        let inner = |node: &&Node<S, K>| matches!(node.content, Content::Inner { .. });
        let inner_cells = self.nodes.iter().filter(inner).count() as u64;
        let bytes = size_of_val(self.nodes.as_slice()) + size_of_val(self.ids.as_slice());
        StructureStats {
            inner_cells,
            cells: self.nodes.len() as u64 - inner_cells,
            references: self.ids.len() as u64,
            bytes: bytes as u64,
            ..StructureStats::default()
        }
    }
}

#[inline(always)]
fn range(first: u32, count: u32) -> std::ops::Range<usize> {
    first as usize..(first + count) as usize
}

/// Orders the ids and says what each node holds, parents before children. Every cut halves, so no
/// leaf lies deeper than the logarithm of the number of primitives, whatever they look like.
fn cut_to_leaves<S: Scalar>(
    ids: &mut [u32],
    centres: &Centres<S>,
    settings: &Settings<KayKajiyaConfig>,
) -> Result<Vec<Content>, BuildError> {
    let leaf_size = settings.leaf_size;
    let branching = settings.branching;
    let mut contents = vec![Content::Leaf { first: 0, count: ids.len() as u32 }];
    let mut next = 0;
    while let Some(&Content::Leaf { first, count }) = contents.get(next) {
        if count as usize > leaf_size {
            let part = &mut ids[range(first, count)];
            let children = cut(part, leaf_size, branching, centres);
            let inner =
                Content::Inner { first: contents.len() as u32, count: children.len() as u32 };
            check_cells(contents.len() + children.len(), settings.limits(), settings.max_cells)?;
            contents[next] = inner;
            let mut first = first;
            for count in children {
                contents.push(Content::Leaf { first, count });
                first += count;
            }
        }
        next += 1;
    }
    Ok(contents)
}

/// Cuts ids into up to `branching` parts by halving those that are too large for a leaf; returns
/// their sizes.
fn cut<S: Scalar>(
    ids: &mut [u32],
    leaf_size: usize,
    branching: usize,
    centres: &Centres<S>,
) -> Vec<u32> {
    let mut parts = vec![ids];
    while parts.len() < branching && parts.iter().any(|part| part.len() > leaf_size) {
        let mut halves = Vec::with_capacity(2 * parts.len());
        for part in parts {
            if part.len() <= leaf_size {
                halves.push(part);
                continue;
            }
            let lower = part.len().div_ceil(2);
            centres.cut(part, lower);
            let (left, right) = part.split_at_mut(lower);
            halves.push(left);
            halves.push(right);
        }
        parts = halves;
    }
    parts.iter().map(|part| part.len() as u32).collect()
}
