//! A counting sort on all threads of the current rayon pool: each part of the input is counted and
//! filled in by itself.
//!
//! Paper: T. Ize, I. Wald, C. Robertson, S. Parker, "An Evaluation of Parallel Grid Construction
//! for Ray Tracing Dynamic Scenes", IEEE Symposium on Interactive Ray Tracing, 2006 (their
//! sort-last build: each thread has a grid for its part of the primitives, merged in the end).
//!
//! Deviations: a thread has only counters, not lists; they are turned into the places in the one
//! array at which it then fills its primitives in, so nothing is merged or moved. Parts stand in
//! their order within each list, so lists are the same for any number of threads.

use std::ops::Range;
use std::sync::atomic::AtomicU32;

use crate::counting_sort::turn_parts_into_ends;
use crate::parallel::{map, parts, ranges};

/// Counters of all parts together may take as much memory as this for each primitive.
const COUNTER_BYTES: usize = 256;

/// Parts of the input: no more than there is memory for, as each has counters of its own.
pub(super) fn useful_parts(primitives: usize, cells: usize) -> Vec<Range<usize>> {
    let affordable = primitives.saturating_mul(COUNTER_BYTES / 4) / cells.max(1);
    ranges(primitives, parts(primitives).min(affordable.max(1)))
}

/// Lengths of the lists in a part (and a zero), and their sum.
pub(super) type Counts = (Vec<u32>, u64);

/// As [`filled`], of one part.
#[inline(always)]
pub(super) fn filled_whole(
    (mut cursors, total): Counts,
    most: u64,
    fill: impl FnOnce(&mut [u32], &mut [u32]),
) -> Result<(Vec<u32>, Vec<u32>), u64> {
    if total > most.min(u64::from(u32::MAX)) {
        return Err(total);
    }
    turn_into_ends(&mut cursors);
    let mut numbers = vec![0; total as usize];
    fill(&mut cursors, &mut numbers);
    Ok((cursors, numbers))
}

/// Turns the counts of lists into where each ends.
#[inline(always)]
pub(super) fn turn_into_ends(counts: &mut [u32]) {
    let mut sum = 0;
    for n in counts {
        sum += *n;
        *n = sum;
    }
}

/// Writes the numbers of a part.
type Fill<'a> = dyn Fn(Range<usize>, &mut [u32], &[AtomicU32]) + Sync + 'a;

/// Starts of lists, one more than there are lists, and their numbers. `fill` writes the numbers of
/// a part, each cursor going down from the end of the part's numbers in that list to their start.
///
/// # Errors
/// How many numbers there are, if these are more than `most`.
pub(super) fn filled(
    mut counted: Vec<Counts>,
    mut parts: Vec<Range<usize>>,
    is_reversed: bool,
    most: u64,
    fill: &Fill<'_>,
) -> Result<(Vec<u32>, Vec<u32>), u64> {
    if counted.len() == 1
        && let (Some(only), Some(part)) = (counted.pop(), parts.pop())
    {
        return filled_whole(only, most, |cursors, numbers| {
            fill(part, cursors, shared(numbers));
        });
    }
    let total = counted.iter().fold(0u64, |sum, (_, n)| sum.saturating_add(*n));
    if total > most.min(u64::from(u32::MAX)) {
        return Err(total);
    }
    let mut cursors: Vec<Vec<u32>> = counted.into_iter().map(|(counts, _)| counts).collect();
    // the part whose numbers come first in a list comes first: its cursors end as the lists' starts
    if is_reversed {
        cursors.reverse();
        parts.reverse();
    }
    turn_parts_into_ends(&mut cursors);
    let mut numbers = vec![0; total as usize];
    let shared = shared(&mut numbers);
    map(cursors.iter_mut().zip(parts), &|(cursors, part)| fill(part, cursors, shared));
    Ok((cursors.into_iter().next().unwrap_or_default(), numbers))
}

/// The same numbers, to be written by several threads, each in places of its own.
fn shared(numbers: &mut [u32]) -> &[AtomicU32] {
    let shared = std::ptr::from_mut(numbers) as *const [AtomicU32];
    // SAFETY: an AtomicU32 has the size, alignment and bit validity of a u32, and for the lifetime
    // of the result nothing else refers to the numbers.
    unsafe { &*shared }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::structures::test_scenes::on_threads;

    #[test]
    fn the_number_of_chunks_fits_the_memory() {
        let parts = |items, cells| on_threads(8, || useful_parts(items, cells));
        let lengths = [200_000, 2_000_000, 50_000_000].map(|cells| parts(100_000, cells).len());
        assert_eq!(lengths, [8, 3, 1]);
        assert_eq!(parts(0, 9), vec![0..0; 1]);
        assert!(parts(100_003, 9).into_iter().flatten().eq(0..100_003));
    }
}
