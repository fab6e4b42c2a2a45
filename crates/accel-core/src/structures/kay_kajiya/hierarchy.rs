//! The hierarchy: built from the top by median cuts, traversed nearest entry first.

use std::ops::Range;

use crate::config;
use crate::geometry::ray::Ray;
use crate::geometry::scalar::Scalar;
use crate::historical::bounds_rule::BoundsOf;
use crate::parallel::{collect, for_each};
use crate::params::ParamSpec;
use crate::params::config::Settings;
use crate::query::cells::{Cell, CellVisitor};
use crate::query::kernel;
use crate::query::sink::Sink;
use crate::structure::{BuildError, StructureStats};
use crate::structures::bounding_volumes::slabs::Slabs;
use crate::structures::bounding_volumes::volume::Volume;
use crate::structures::bounding_volumes::{DIRECTIONS, MAX_CELLS, check_cells};
use crate::structures::kay_kajiya::entry_queue::EntryQueue;
use crate::tree::median_cut::Centres;

config! {
    /// How the hierarchy is built.
    pub struct KayKajiyaConfig {
        pub(super) directions: u64 = DIRECTIONS,
        /// primitives that a leaf may hold
        pub(super) leaf_size: usize = ParamSpec::integer("leaf-size", "1", 1, 1 << 20),
        /// children that a node may have
        pub(super) branching: usize = ParamSpec::choice("branching", "2", &["2", "4", "8"]),
        pub(super) max_cells: u64 = MAX_CELLS,
    }
    and kernel::PARAM
}

/// A volume and what it holds.
#[derive(Debug, Clone, Copy)]
struct Node<S, const K: usize> {
    volume: Slabs<S, K>,
    content: Content,
}

/// Contents of a node, as a range.
#[derive(Debug, Clone, Copy)]
enum Content {
    Inner {
        first: u32,
        count: u32,
    },
    /// Range in the list of ids.
    Leaf {
        first: u32,
        count: u32,
    },
}

/// Volumes of `K` slabs; node 0 is the root, children come after their parents.
pub(super) struct Hierarchy<S, const K: usize> {
    nodes: Vec<Node<S, K>>,
    ids: Vec<u32>,
}

impl<S: Scalar, const K: usize> Hierarchy<S, K> {
    /// Builds it over all primitives.
    pub(super) fn new(
        boxes: &BoundsOf<S>,
        settings: &Settings<KayKajiyaConfig>,
    ) -> Result<Self, BuildError> {
        let mut ids: Vec<u32> = (0..boxes.prims().len() as u32).collect();
        let (contents, levels) = contents(ids.len(), settings)?;
        Centres::of(boxes.prims()).cut_again(&mut ids, &|n| halved(n, settings.leaf_size));
        let node = |number: usize| Node { volume: Slabs::empty(), content: contents[number] };
        let mut this = Self { nodes: collect(contents.len(), node), ids };
        this.bound(&levels, boxes);
        Ok(this)
    }

    /// Makes the volumes, children before parents, those of a level on all threads.
    fn bound(&mut self, levels: &[Range<usize>], boxes: &BoundsOf<S>) {
        for level in levels.iter().rev() {
            let (above, below) = self.nodes.split_at_mut(level.end);
            for_each(&mut above[level.start..], |node| {
                node.volume = match node.content {
                    Content::Inner { first, count } => below
                        [range(first - level.end as u32, count)]
                    .iter()
                    .fold(Slabs::empty(), |all, child| all.union(&child.volume)),
                    Content::Leaf { first, count } => {
                        Slabs::around(&self.ids[range(first, count)], boxes)
                    }
                };
            });
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
fn range(first: u32, count: u32) -> Range<usize> {
    first as usize..(first + count) as usize
}

/// Contents of the nodes over this many ids, parents first, and the ranges of the levels. Every cut
/// halves, so the depth is logarithmic in the number of primitives.
fn contents(
    ids: usize,
    settings: &Settings<KayKajiyaConfig>,
) -> Result<(Vec<Content>, Vec<Range<usize>>), BuildError> {
    let mut contents = vec![Content::Leaf { first: 0, count: ids as u32 }];
    let (mut levels, mut level) = (Vec::new(), 0..1);
    while !level.is_empty() {
        // nodes of a level differ by a few ids at most
        let mut known: Vec<(u32, Vec<usize>)> = Vec::new();
        for number in level.clone() {
            let Content::Leaf { mut first, count } = contents[number] else { continue };
            if halved(count as usize, settings.leaf_size).is_none() {
                continue;
            }
            let place = known.iter().position(|(n, _)| *n == count).unwrap_or_else(|| {
                known.push((count, parts(count as usize, settings)));
                known.len() - 1
            });
            let children = &known[place].1;
            let nodes = contents.len() + children.len();
            check_cells(nodes, settings.limits(), settings.max_cells)?;
            contents[number] =
                Content::Inner { first: contents.len() as u32, count: children.len() as u32 };
            for &count in children {
                let count = count as u32;
                contents.push(Content::Leaf { first, count });
                first += count;
            }
        }
        let below = level.end..contents.len();
        levels.push(std::mem::replace(&mut level, below));
    }
    Ok((contents, levels))
}

/// The lower half of so many ids, where they are too many for a leaf.
fn halved(ids: usize, leaf_size: usize) -> Option<usize> {
    (ids > leaf_size).then(|| ids.div_ceil(2))
}

/// The children of a node over so many ids: up to so many as it may have, by halving those that are
/// too large for a leaf.
fn parts(ids: usize, settings: &Settings<KayKajiyaConfig>) -> Vec<usize> {
    let mut parts = vec![ids];
    while parts.len() < settings.branching && parts.iter().any(|&n| n > settings.leaf_size) {
        let halves = parts.into_iter().flat_map(|n| {
            let lower = halved(n, settings.leaf_size);
            [lower.unwrap_or(n), lower.map_or(0, |lower| n - lower)]
        });
        parts = halves.filter(|&n| n > 0).collect();
    }
    parts
}
