//! One ray's way through the tree: at a node its eight boxes are tested at once, the children that
//! are met are sorted and pushed, and the nearest comes next; at a leaf its triangles are tested.
//!
//! Paper: I. Wald, C. Benthin, S. Boulos, "Getting Rid of Packets: Efficient SIMD Single-Ray
//! Traversal using Multi-branching BVHs", RT 2008. Deviations: where any hit ends the query, the
//! children come in the node's own order (`collapsed.rs`); where a ray runs like the one before,
//! the next child is told by a branch, as in the BVH4 of tinybvh 1.9 for all rays. The test of the
//! boxes, and where a ray's interval ends, is in `node.rs`; eight rays at once are in
//! `node_ray_lanes.rs` and `packet.rs`.

use std::arch::asm;
use std::cell::Cell;
use std::mem::MaybeUninit;
use std::ops::ControlFlow;

use glam::Vec3A;
use wide::f32x8;

use super::WideBvh;
use super::collapse::LEVELS;
use super::node::{BoxParameters, BoxRay, LEAF, Length, Node, NodeRay, WIDTH};
use crate::geometry::lanes::take_lowest;
use crate::geometry::ray::Ray;
use crate::geometry::scalar::Scalar;
use crate::memory::prefetch;
use crate::query::ray_order::ALIKE;
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
        let is_foreseen = runs_like_the_last(origin, direction);
        let _ = self.traverse_from(self.root, of_nodes, is_foreseen, parameters, end, sink);
    }

    /// The traversal from a child on, which a ray enters before its parameter `end`; `Break` when
    /// the query is over. `is_foreseen`: as in [`Stack`].
    #[inline(always)]
    pub(super) fn traverse_from<K: Sink<S>>(
        &self,
        mut at: u32,
        ray: NodeRay,
        is_foreseen: bool,
        parameters: BoxParameters<S>,
        mut end: f32,
        sink: &mut K,
    ) -> ControlFlow<()> {
        let mut room = Stack::room();
        let mut stack = Stack::new(&mut room, is_foreseen);
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

thread_local! {
    /// Origin and direction of this thread's last ray, as boxes see them.
    static LAST: Cell<[Vec3A; 2]> = const { Cell::new([Vec3A::ZERO; 2]) };
}

/// Returns whether the ray before, on this thread, began near this one and ran alike. It decides how
/// children are told, not which: no answer or counter depends on it.
#[inline(always)]
pub(super) fn runs_like_the_last(origin: Vec3A, direction: Vec3A) -> bool {
    let [last_origin, last_direction] = LAST.replace([origin, direction]);
    let apart = (origin - last_origin).abs();
    let turned = (direction - last_direction).abs();
    let most = Vec3A::splat(ALIKE);
    (apart.cmple(most) & turned.cmple(most * direction.abs().max_element())).all()
}

/// Keeps the branch that leads here: a comment in the machine code, in each place another.
macro_rules! keep_branch {
    ($place:literal) => {
        // SAFETY: no instruction
        unsafe { asm!(concat!("/* ", $place, " */"), options(nomem, nostack, preserves_flags)) }
    };
}

/// Capacity: a node pushes at most `WIDTH - 1` children per level, plus one full node at the
/// bottom.
const ROOM: usize = LEVELS as usize * (WIDTH - 1) + WIDTH;

/// Entry distance (bits of an f32, +0 at least) in the upper half, node index in the lower:
/// comparing two as integers compares their distances.
type Entry = u64;

/// Nodes to visit, with their entry distances; within one parent, nearer children lie above farther
/// ones.
pub(super) struct Stack<'r> {
    /// Those below `waiting` were written. They lie apart from `waiting`, which then is in a
    /// register.
    entries: &'r mut [MaybeUninit<Entry>; ROOM],
    waiting: usize,
    /// The ray goes the way of the one before, so that branches on where it goes are foreseen.
    is_foreseen: bool,
}

impl<'r> Stack<'r> {
    /// Room for the entries of one.
    #[inline(always)]
    pub(super) fn room() -> [MaybeUninit<Entry>; ROOM] {
        [const { MaybeUninit::uninit() }; ROOM]
    }

    #[inline(always)]
    pub(super) fn new(entries: &'r mut [MaybeUninit<Entry>; ROOM], is_foreseen: bool) -> Self {
        Self { entries, waiting: 0, is_foreseen }
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
        // an end may be negative: all rays of a packet are done
        let last = i64::from(end.to_bits() as i32) << 32 | i64::from(u32::MAX);
        while self.waiting > 0 {
            self.waiting -= 1;
            // SAFETY: what lies below `waiting` was written
            let entry = unsafe { self.entries[self.waiting].assume_init() };
            if entry as i64 <= last {
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

    /// The name of a child, where the ray goes next. Foreseen, it is read where a branch on the
    /// child's number leads, and the processor tests the child's boxes before it knows those of
    /// the node; else a number in a register is waited for, and no wrong way is undone.
    #[inline(always)]
    fn chosen(&self, child: u32, name: impl Fn(usize) -> u32) -> u32 {
        macro_rules! branches {
            ($($number:literal)*) => {
                match child {
                    $($number => {
                        keep_branch!($number);
                        name($number)
                    })*
                    _ => name(WIDTH - 1),
                }
            };
        }
        if self.is_foreseen { branches!(0 1 2 3 4 5 6) } else { name(child as usize & (WIDTH - 1)) }
    }

    /// One of the children that the ray meets, a bit each; the others wait, in no order.
    #[inline(always)]
    fn any_of(&mut self, met: u32, name: impl Fn(usize) -> u32) -> u32 {
        // read before it is known how many wait
        let first = self.chosen(met.trailing_zeros(), &name);
        let mut others = met & met.wrapping_sub(1);
        while others != 0 {
            self.push(u64::from(name(take_lowest(&mut others) & (WIDTH - 1))));
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
            u64::from(enter[child].to_bits()) << 32 | u64::from(name(child))
        };
        let mut take = || {
            let child = met.trailing_zeros();
            met &= met.wrapping_sub(1);
            (child, met == 0)
        };
        let (first, is_last) = take();
        if is_last {
            // where the ray enters it is not waited for
            return self.chosen(first, name);
        }
        let (second, is_last) = take();
        let (a, b) = (entry(first), entry(second));
        if is_last {
            if !self.is_foreseen {
                self.push(a.max(b));
                return a.min(b) as u32;
            }
            if a < b {
                keep_branch!("nearer");
                self.push(b);
                return self.chosen(first, name);
            }
            self.push(a);
            return self.chosen(second, name);
        }
        let mut next = || {
            let (child, is_last) = take();
            (entry(child), is_last)
        };
        let (a, b) = (a.min(b), a.max(b));
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bvh::INFO;
    use crate::geometry::ray::Hit;
    use crate::params::config::Settings;
    use crate::primitives::MixedSet;
    use crate::query::counters::WorkCounters;
    use crate::query::sink::{Answer, Query};
    use crate::structure::Structure;
    use crate::structures::test_scenes::{mixed_scene, rays};

    /// The answer and what it took, with branches and without.
    fn both_ways<A: Answer<f32>>(
        bvh: &WideBvh<f32>,
        set: &MixedSet<f32>,
        ray: &Ray<f32>,
    ) -> [(A, WorkCounters); 2] {
        [true, false].map(|is_foreseen| {
            let mut query = Query::<_, _, WorkCounters, A>::new(set, ray);
            let BoxRay { origin, direction, parameters } = bvh.setup.ray(ray, Length::Own);
            let of_nodes = NodeRay::of(origin, direction, false);
            let end = parameters.bound(query.t_max());
            let _ = bvh.traverse_from(bvh.root, of_nodes, is_foreseen, parameters, end, &mut query);
            query.finish()
        })
    }

    #[test]
    fn branches_lead_the_same_way() {
        let set = mixed_scene::<f32>(2000, 8, [1.0; 3]);
        let bvh = WideBvh::build(&set, &Settings::of(&INFO.defaults())).unwrap();
        let mut steps = 0;
        for ray in rays(&set, 3000, 9) {
            let [a, b] = both_ways::<Hit<f32>>(&bvh, &set, &ray);
            assert_eq!(a, b, "{ray:?}");
            steps += a.1.traversal_steps;
            let [a, b] = both_ways::<bool>(&bvh, &set, &ray);
            assert_eq!(a, b, "{ray:?}");
        }
        assert!(steps > 20_000, "{steps}");
    }

    #[test]
    fn a_ray_that_turns_or_begins_elsewhere_is_not_like_the_last() {
        let like = |o: [f32; 3], d: [f32; 3]| runs_like_the_last(o.into(), d.into());
        like([0.5; 3], [2.0, 0.0, 0.0]);
        assert!(like([0.5; 3], [2.0, 0.2, 0.0]));
        assert!(like([0.5, 0.4, 0.5], [2.0, 0.2, 0.0]));
        assert!(!like([0.5, 0.8, 0.5], [2.0, 0.2, 0.0]));
        assert!(!like([0.5, 0.8, 0.5], [2.0, 0.2, 0.5]));
        assert!(like([0.5, 0.8, 0.5], [2.0, 0.2, 0.5]));
    }
}
