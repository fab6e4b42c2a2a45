//! The queue of volumes a ray has yet to visit, nearest entry first.

use crate::geometry::scalar::Scalar;

/// Entries that need no memory of their own; more than most rays ever have waiting.
const INLINE: usize = 64;

/// A volume that waits: where the ray enters it, and its number.
pub(super) type QueuedVolume<S> = (S, u32);

/// A binary heap on the stack; one that outgrows its room moves to a vector.
pub(super) struct EntryQueue<S> {
    inline: [QueuedVolume<S>; INLINE],
    len: usize,
    /// All of them, once there were more than [`INLINE`]; empty before.
    spilled: Vec<QueuedVolume<S>>,
}

impl<S: Scalar> EntryQueue<S> {
    #[inline(always)]
    pub(super) fn new() -> Self {
        Self { inline: [(S::ZERO, 0); INLINE], len: 0, spilled: Vec::new() }
    }

    #[inline(always)]
    fn entries(&mut self) -> &mut [QueuedVolume<S>] {
        if self.spilled.is_empty() { &mut self.inline } else { &mut self.spilled }
    }

    #[inline(always)]
    pub(super) fn push(&mut self, entry: QueuedVolume<S>) {
        let last = self.len;
        if last >= self.entries().len() {
            self.spill();
        }
        self.len += 1;
        let heap = self.entries();
        heap[last] = entry;
        let mut at = last;
        while at > 0 {
            let parent = (at - 1) / 2;
            if heap[parent].0 <= heap[at].0 {
                break;
            }
            heap.swap(parent, at);
            at = parent;
        }
    }

    /// Removes the volume that is entered first.
    #[inline(always)]
    pub(super) fn pop(&mut self) -> Option<QueuedVolume<S>> {
        let last = self.len.checked_sub(1)?;
        self.len = last;
        let heap = &mut self.entries()[..=last];
        heap.swap(0, last);
        let first = heap[last];
        let heap = &mut heap[..last];
        let mut at = 0;
        while let Some(child) = nearer_child(heap, at) {
            if heap[at].0 <= heap[child].0 {
                break;
            }
            heap.swap(at, child);
            at = child;
        }
        Some(first)
    }

    #[cold]
    #[inline(never)]
    fn spill(&mut self) {
        let mut all = self.entries().to_vec();
        all.resize(2 * all.len(), (S::ZERO, 0));
        self.spilled = all;
    }
}

#[inline(always)]
fn nearer_child<S: Scalar>(heap: &[QueuedVolume<S>], parent: usize) -> Option<usize> {
    let left = 2 * parent + 1;
    let nearest = heap.get(left)?.0;
    Some(if heap.get(left + 1).is_some_and(|right| right.0 < nearest) { left + 1 } else { left })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn entries_come_in_order_whether_spilled_or_not() {
        for n in [1u32, 2, 63, 64, 65, 1000] {
            let mut queue = EntryQueue::new();
            for i in 0..n {
                queue.push((f64::from(i * 7919 % n), i));
                // a pop between, so that the heap is not only ever filled
                if i % 3 == 2 {
                    let popped = queue.pop().unwrap();
                    queue.push(popped);
                }
            }
            let mut popped = Vec::new();
            while let Some((t, number)) = queue.pop() {
                assert_eq!(t, f64::from(number * 7919 % n));
                popped.push(t);
            }
            assert_eq!(popped.len(), n as usize);
            assert!(popped.is_sorted(), "{n}: {popped:?}");
            assert!(queue.pop().is_none());
        }
    }
}
