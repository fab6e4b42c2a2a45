//! One ray's way through the tree: at a node its eight boxes are tested at once, the children that
//! are met are sorted and pushed, and the nearest comes next; at a leaf its triangles are tested.
//!
//! Paper: I. Wald, C. Benthin, S. Boulos, "Getting Rid of Packets: Efficient SIMD Single-Ray
//! Traversal using Multi-branching BVHs", RT 2008. Deviation: where any hit ends the query, the
//! children come in the node's own order (`collapsed.rs`). The test of the boxes, and where a ray's
//! interval ends, is in `node.rs`; eight rays at once are in `node_ray_lanes.rs` and `packet.rs`.

use std::mem::MaybeUninit;
use std::ops::ControlFlow;

use wide::f32x8;

use super::WideBvh;
use super::collapse::LEVELS;
use super::node::{BoxParameters, BoxRay, LEAF, Length, Node, NodeRay, WIDTH};
use crate::geometry::ray::Ray;
use crate::geometry::scalar::Scalar;
use crate::memory::prefetch;
use crate::query::sink::Sink;

impl<S: Scalar> WideBvh<S> {
    /// Tests the primitives that a ray may hit.
    #[inline(always)]
    pub(super) fn traverse_ray<K: Sink<S>>(&self, ray: &Ray<S>, sink: &mut K) {
        let BoxRay { origin, direction, parameters } = self.setup.ray(ray, Length::Own);
        let of_nodes = if self.is_unpadded {
            NodeRay::unpadded(origin, direction)
        } else {
            NodeRay::of(origin, direction, self.is_exact && !parameters.starts_earlier())
        };
        let end = parameters.bound(sink.t_max());
        let _ = self.traverse_from(self.root, of_nodes, parameters, end, sink);
    }

    /// The traversal from a child on, which a ray enters before its parameter `end`; `Break` when
    /// the query is over.
    #[inline(always)]
    pub(super) fn traverse_from<K: Sink<S>>(
        &self,
        mut at: u32,
        ray: NodeRay,
        parameters: BoxParameters<S>,
        mut end: f32,
        sink: &mut K,
    ) -> ControlFlow<()> {
        let mut room = Stack::room();
        let mut stack = Stack::new(&mut room);
        loop {
            while at & LEAF == 0 {
                sink.inner_step();
                let node = &self.nodes[at as usize];
                let name = |child: usize| node.children[child];
                match stack.descend(node, &ray, end, sink.is_any_hit(), name) {
                    Some(next) => at = next,
                    None => return ControlFlow::Continue(()),
                }
            }
            sink.elementary_step(false);
            self.lists.test(at & !LEAF, sink)?;
            if !sink.is_any_hit() {
                end = parameters.bound(sink.t_max());
            }
            match stack.pop(end) {
                Some(next) => at = next,
                None => return ControlFlow::Continue(()),
            }
        }
    }

    /// Begins to load a child.
    #[inline(always)]
    pub(super) fn prefetch(&self, child: u32) {
        match child & LEAF {
            0 => prefetch(&self.nodes[child as usize]),
            _ => self.lists.prefetch(child & !LEAF),
        }
    }
}

/// Capacity: a node pushes at most `WIDTH - 1` children per level, plus one full node at the
/// bottom.
const ROOM: usize = LEVELS as usize * (WIDTH - 1) + WIDTH;

/// Entry distance (bits of an f32 >= 0) in the upper half, node index in the lower: comparing two
/// as integers compares their distances.
type Entry = u64;

const SIGN: u32 = 1 << 31;

/// Nodes to visit, with their entry distances; within one parent, nearer children lie above farther
/// ones.
pub(super) struct Stack<'r> {
    /// Those below `waiting` were written. They lie apart from `waiting`, which then is in a
    /// register.
    entries: &'r mut [MaybeUninit<Entry>; ROOM],
    waiting: usize,
}

impl<'r> Stack<'r> {
    /// Room for the entries of one.
    #[inline(always)]
    pub(super) fn room() -> [MaybeUninit<Entry>; ROOM] {
        [const { MaybeUninit::uninit() }; ROOM]
    }

    #[inline(always)]
    pub(super) fn new(entries: &'r mut [MaybeUninit<Entry>; ROOM]) -> Self {
        Self { entries, waiting: 0 }
    }

    #[inline(always)]
    fn push(&mut self, entry: Entry) {
        self.entries[self.waiting].write(entry);
        self.waiting += 1;
    }

    /// Pushes an entry below the nearer ones among those from `first` on.
    #[inline(always)]
    fn insert(&mut self, entry: Entry, first: usize) {
        let mut place = self.waiting;
        while place > first {
            // SAFETY: what lies below `waiting` was written
            let above = unsafe { self.entries[place - 1].assume_init() };
            if above >= entry {
                break;
            }
            self.entries[place].write(above);
            place -= 1;
        }
        self.entries[place].write(entry);
        self.waiting += 1;
    }

    /// The next child that the ray enters before `end`.
    #[inline(always)]
    pub(super) fn pop(&mut self, end: f32) -> Option<u32> {
        while self.waiting > 0 {
            self.waiting -= 1;
            // SAFETY: what lies below `waiting` was written
            let entry = unsafe { self.entries[self.waiting].assume_init() };
            if f32::from_bits((entry >> 32) as u32) <= end {
                return Some(entry as u32);
            }
        }
        None
    }

    /// One of a node's children that the ray meets before `end`, the nearest of them unless any hit
    /// ends the query; the others wait. With none the next that waits. `name` has what a child is
    /// known by here.
    #[inline(always)]
    pub(super) fn descend(
        &mut self,
        node: &Node,
        ray: &NodeRay,
        end: f32,
        is_any_hit: bool,
        name: impl Fn(usize) -> u32,
    ) -> Option<u32> {
        let (met, enter) = ray.test(node, end);
        if met == 0 {
            self.pop(end)
        } else if is_any_hit {
            Some(self.any_of(met, name))
        } else {
            Some(self.nearest_of(met, enter, name))
        }
    }

    /// One of the children that the ray meets, a bit each; the others wait, in no order.
    #[inline(always)]
    fn any_of(&mut self, mut met: u32, name: impl Fn(usize) -> u32) -> u32 {
        let mut next = || {
            let child = name(met.trailing_zeros() as usize & (WIDTH - 1));
            met &= met.wrapping_sub(1);
            (child, met == 0)
        };
        let (first, mut is_last) = next();
        while !is_last {
            let child;
            (child, is_last) = next();
            self.push(u64::from(child));
        }
        first
    }

    /// The nearest of the children that the ray meets, a bit each; the others wait. `enter`: where
    /// it enters them.
    #[inline(always)]
    fn nearest_of(&mut self, mut met: u32, enter: f32x8, name: impl Fn(usize) -> u32) -> u32 {
        let enter = enter.to_array();
        let entry = |child: u32| {
            let child = child as usize & (WIDTH - 1);
            // parameters are not negative, and so in the order of their bits
            let key = u64::from(enter[child].to_bits() & !SIGN);
            key << 32 | u64::from(name(child))
        };
        let mut take = || {
            let child = met.trailing_zeros();
            met &= met.wrapping_sub(1);
            (child, met == 0)
        };
        let (first, is_last) = take();
        if is_last {
            // where the ray enters it is not waited for
            return name(first as usize & (WIDTH - 1));
        }
        let a = entry(first);
        let mut next = || {
            let (child, is_last) = take();
            (entry(child), is_last)
        };
        let (b, is_last) = next();
        let (a, b) = (a.min(b), a.max(b));
        if is_last {
            self.push(b);
            return a as u32;
        }
        let (c, is_last) = next();
        let (b, c) = (b.min(c), b.max(c));
        let (a, b) = (a.min(b), a.max(b));
        let first = self.waiting;
        self.push(c);
        self.push(b);
        let mut nearest = a;
        if !is_last {
            loop {
                let (d, is_last) = next();
                let (near, far) = (nearest.min(d), nearest.max(d));
                nearest = near;
                self.insert(far, first);
                if is_last {
                    break;
                }
            }
        }
        nearest as u32
    }
}
