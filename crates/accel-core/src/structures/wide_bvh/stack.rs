//! The traversal stack of the wide BVH: nodes still to visit, with their entry distances.

use std::mem::MaybeUninit;

use super::collapse::WIDTH;
use super::node::{Node, NodeRay};

/// Upper bound on the depth of the binary tree; collapsing only makes it shallower.
pub(super) const LEVELS: u32 = 96;
/// Capacity: a node pushes at most `WIDTH - 1` children per level, plus one full node at the
/// bottom.
const ROOM: usize = LEVELS as usize * (WIDTH - 1) + WIDTH;

/// Entry distance (bits of an f32 >= 0) in the upper half, node index in the lower: comparing two
/// as integers compares their distances.
type Entry = u64;

const SIGN: u32 = 1 << 31;

/// Memory of a stack. The length is kept apart so that it can stay in a register.
pub struct StackStorage([MaybeUninit<Entry>; ROOM]);

impl Default for StackStorage {
    #[inline(always)]
    fn default() -> Self {
        Self([const { MaybeUninit::uninit() }; ROOM])
    }
}

/// Nodes to visit; within one parent, nearer children lie above farther ones.
pub(super) struct Stack<'a> {
    entries: &'a mut [MaybeUninit<Entry>; ROOM],
    waiting: &'a mut usize,
}

impl<'a> Stack<'a> {
    /// Stack of the first `len` entries of the storage.
    ///
    /// # Safety
    /// A stack wrote them.
    #[inline(always)]
    pub(super) unsafe fn new(room: &'a mut StackStorage, waiting: &'a mut usize) -> Self {
        Self { entries: &mut room.0, waiting }
    }

    #[inline(always)]
    fn push(&mut self, entry: Entry) {
        self.entries[*self.waiting].write(entry);
        *self.waiting += 1;
    }

    /// Pushes an entry below the nearer ones among those from `first` on.
    #[inline(always)]
    fn insert(&mut self, entry: Entry, first: usize) {
        let mut place = *self.waiting;
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
        *self.waiting += 1;
    }

    /// The next child that the ray enters before `end`.
    #[inline(always)]
    pub(super) fn pop(&mut self, end: f32) -> Option<u32> {
        while *self.waiting > 0 {
            *self.waiting -= 1;
            // SAFETY: what lies below `waiting` was written
            let entry = unsafe { self.entries[*self.waiting].assume_init() };
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
        let next = if is_any_hit {
            self.any_of(node, ray, end, name)
        } else {
            self.nearest_of(node, ray, end, name)
        };
        next.or_else(|| self.pop(end))
    }

    /// One of the children that the ray meets; the others wait, in no order.
    #[inline(always)]
    fn any_of(
        &mut self,
        node: &Node,
        ray: &NodeRay,
        end: f32,
        name: impl Fn(usize) -> u32,
    ) -> Option<u32> {
        let (mut met, _) = ray.test(node, end);
        if met == 0 {
            return None;
        }
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
        Some(first)
    }

    /// The nearest of the children that the ray meets; the others wait.
    #[inline(always)]
    fn nearest_of(
        &mut self,
        node: &Node,
        ray: &NodeRay,
        end: f32,
        name: impl Fn(usize) -> u32,
    ) -> Option<u32> {
        let (mut met, enter) = ray.test(node, end);
        if met == 0 {
            return None;
        }
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
            return Some(name(first as usize & (WIDTH - 1)));
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
            return Some(a as u32);
        }
        let (c, is_last) = next();
        let (b, c) = (b.min(c), b.max(c));
        let (a, b) = (a.min(b), a.max(b));
        let first = *self.waiting;
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
        Some(nearest as u32)
    }
}
