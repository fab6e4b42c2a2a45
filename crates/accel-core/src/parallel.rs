//! How a build divides its work among the threads of the current rayon pool.
//!
//! Work is cut by position, never by who comes first, and put together in order: what is built is
//! the same, bit for bit, for any number of threads. On one thread rayon is not even called.

use std::mem::MaybeUninit;
use std::ops::Range;
use std::sync::Mutex;

use rayon::prelude::*;

/// Fewer primitives than this are not worth a thread of their own.
const LEAST_PRIMITIVES: usize = 4096;

/// Into how many parts to cut work on so many primitives: one for each thread, if that pays.
pub(crate) fn parts(primitives: usize) -> usize {
    match primitives / LEAST_PRIMITIVES {
        0 | 1 => 1,
        most => most.min(rayon::current_num_threads()),
    }
}

/// How many times a recursive build may divide its work: to some parts for each thread, as they
/// differ in size; 0 on one thread.
pub(crate) fn forks() -> u32 {
    match rayon::current_num_threads() {
        0 | 1 => 0,
        threads => threads.next_power_of_two().ilog2() + 4,
    }
}

/// Returns whether so many references are worth dividing among threads, of which there are several.
pub(crate) fn should_parallelize(references: usize) -> bool {
    parts(references) > 1
}

/// Cuts `0..primitives` into [`parts`] and gives what `f` makes of each, in their order.
pub(crate) fn map_parts<T: Send>(primitives: usize, f: impl Fn(Range<u32>) -> T + Sync) -> Vec<T> {
    let ranges = ranges(primitives, parts(primitives));
    map(ranges, &|range| f(range.start as u32..range.end as u32))
}

/// Cuts `0..n` into at most so many parts, at least one, all of one length but for the last.
pub(crate) fn ranges(n: usize, parts: usize) -> Vec<Range<usize>> {
    let length = n.div_ceil(parts).max(1);
    (0..n.max(1)).step_by(length).map(|first| first..(first + length).min(n)).collect()
}

/// Maps `0..n` by `f` in parallel, keeping the order.
pub(crate) fn collect<T: Copy + Send>(n: usize, f: impl Fn(usize) -> T + Sync) -> Vec<T> {
    collect_in_parts(n, &|first, part| {
        part.iter_mut().zip(first..).for_each(|(slot, i)| _ = slot.write(f(i)));
    })
}

/// Maps expensive items by `f` in parallel, keeping the order.
pub(crate) fn map<I: Send, T: Send>(
    items: impl IntoIterator<Item = I>,
    f: &(dyn Fn(I) -> T + Sync),
) -> Vec<T> {
    let items = items.into_iter();
    let is_single = items.size_hint().1.is_some_and(|most| most < 2);
    if is_single || rayon::current_num_threads() == 1 {
        return items.map(f).collect();
    }
    let pairs: Vec<_> = items.map(|item| Mutex::new((Some(item), None))).collect();
    run(pairs.len(), &|i| {
        let Ok(mut pair) = pairs[i].lock() else { return };
        pair.1 = pair.0.take().map(f);
    });
    // a panic of `f` has been passed on, so that there is a value for each item
    pairs.into_iter().filter_map(|pair| pair.into_inner().ok()?.1).collect()
}

/// Calls `job` with each number below `n`. All work that is cut goes through here but for what is
/// halved or sorted: what rayon makes of a closure's type is compiled once.
fn run(n: usize, job: &(dyn Fn(usize) + Sync)) {
    (0..n).into_par_iter().for_each(job);
}

/// Cuts off one piece of each length, from the front on.
pub(crate) fn split_mut<T>(
    mut items: &mut [T],
    lengths: impl IntoIterator<Item = usize>,
) -> impl Iterator<Item = &mut [T]> {
    lengths.into_iter().map_while(move |length| items.split_off_mut(..length))
}

/// Sorts numbers of which none is there twice.
pub(crate) fn sort<T: Ord + Send>(numbers: &mut [T]) {
    match parts(numbers.len()) {
        1 => numbers.sort_unstable(),
        _ => numbers.par_sort_unstable(),
    }
}

/// Calls `f` with each item.
pub(crate) fn for_each<T: Send>(items: &mut [T], f: impl Fn(&mut T) + Sync) {
    let size = items.len().div_ceil(parts(items.len())).max(1);
    map(items.chunks_mut(size), &|part| part.iter_mut().for_each(&f));
}

/// Exchanges the values of the first pieces, in their order, for those of the others, as many.
pub(crate) fn exchange<T: Send>(first: Vec<&mut [T]>, others: Vec<&mut [T]>) {
    const LONGEST: usize = 1 << 12;
    let mut pairs = Vec::new();
    let mut others = others.into_iter();
    let mut other: &mut [T] = &mut [];
    for mut one in first {
        while !one.is_empty() {
            if other.is_empty() {
                let Some(next) = others.next() else { break };
                other = next;
                continue;
            }
            let n = one.len().min(other.len()).min(LONGEST);
            let (a, b) = (one.split_off_mut(..n), other.split_off_mut(..n));
            pairs.extend(a.zip(b));
        }
    }
    map(pairs, &|(a, b)| a.swap_with_slice(b));
}

/// A piece of a tree, whose first node is its root, and those that other threads made below some of
/// its nodes.
pub(crate) struct ForkedTree<T> {
    pub(crate) piece: T,
    pub(crate) below: Vec<(usize, Self)>,
}

impl<T> ForkedTree<T> {
    /// Lists the pieces, each before those below it, and the places of their roots among the nodes
    /// of all, of which a piece adds `nodes` but for its root.
    pub(crate) fn pieces(self, nodes: impl Fn(&T) -> usize) -> Vec<(usize, T)> {
        let (mut pieces, mut in_front) = (Vec::new(), 0);
        let mut waiting = vec![(0, self)];
        while let Some((root, Self { piece, below })) = waiting.pop() {
            waiting.extend(below.into_iter().rev().map(|(at, below)| (at + in_front, below)));
            in_front += nodes(&piece) - 1;
            pieces.push((root, piece));
        }
        pieces
    }
}

/// Concatenates the pieces, each mapped by `moved`.
pub(crate) fn concat<T: Copy + Send + Sync, M: Copy + Send + Sync>(
    pieces: &[(&[T], M)],
    moved: &(dyn Fn(T, M) -> T + Sync),
) -> Vec<T> {
    const LONGEST: usize = 1 << 14;
    let n = pieces.iter().map(|(values, _)| values.len()).sum();
    let mut all = Vec::with_capacity(n);
    let mut rest = &mut all.spare_capacity_mut()[..n];
    let mut jobs = Vec::new();
    for &(values, by) in pieces {
        for values in values.chunks(LONGEST) {
            let (slots, behind) = rest.split_at_mut(values.len());
            jobs.push((slots, values, by));
            rest = behind;
        }
    }
    map(jobs, &|(slots, values, by)| {
        slots.iter_mut().zip(values).for_each(|(slot, &value)| _ = slot.write(moved(value, by)));
    });
    // SAFETY: the jobs' slots are all of the first `n`, and each has been written
    unsafe { all.set_len(n) };
    all
}

/// A vector of which `write` writes each part, which begins at the place given, wholly. Compiled
/// once for all that write.
fn collect_in_parts<T: Copy + Send>(
    n: usize,
    write: &(dyn Fn(usize, &mut [MaybeUninit<T>]) + Sync),
) -> Vec<T> {
    let mut all = Vec::with_capacity(n);
    let size = n.div_ceil(parts(n)).max(1);
    let parts = all.spare_capacity_mut()[..n].chunks_mut(size).enumerate();
    map(parts, &|(i, part)| write(i * size, part));
    // SAFETY: the parts are all of the first `n`, and each has been written
    unsafe { all.set_len(n) };
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_cover_everything_once_and_in_order() {
        for threads in [1, 2, 5] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            for n in [0, 1, LEAST_PRIMITIVES, 3 * LEAST_PRIMITIVES + 1, 50_001] {
                let ranges = pool.install(|| map_parts(n, |r| r));
                assert_eq!(ranges.len(), threads.min((n / LEAST_PRIMITIVES).max(1)));
                let all: Vec<u32> = ranges.into_iter().flatten().collect();
                assert!(all.iter().copied().eq(0..n as u32), "{threads} threads, {n}");
                assert!(
                    pool.install(|| collect(n, |i| 3 * i)).into_iter().eq((0..n).map(|i| 3 * i))
                );
            }
        }
    }

    #[test]
    fn any_number_of_threads_does_the_same_in_the_same_order() {
        let numbers: Vec<u32> = (0..50_001).map(|i| i * 7919 % 50_021).collect();
        let mut sorted = numbers.clone();
        sorted.sort_unstable();
        // pieces of all lengths, some of none, some longer than a thread copies at once
        let ends = [0, 0, 3, 4000, 4000, 40_000, 50_001];
        let pieces = ends.windows(2).zip(0..).map(|(at, by)| (&numbers[at[0]..at[1]], by));
        let pieces: Vec<(&[u32], u32)> = pieces.collect();
        let joined = pieces.iter().flat_map(|(piece, by)| piece.iter().map(move |n| n + by));
        let joined: Vec<u32> = joined.collect();
        let exchanged: Vec<u32> = [&numbers[25_000..50_000], &numbers[..25_000]].concat();
        for threads in [1, 2, 5] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| {
                let mut own = numbers.clone();
                sort(&mut own);
                assert!(own == sorted);
                for_each(&mut own, |n| *n += 1);
                assert!(own.iter().zip(&sorted).all(|(n, before)| *n == before + 1));
                let taken = map(&mut own[..3], &|n| std::mem::take(n));
                assert!(taken.iter().zip(&sorted).all(|(n, before)| *n == before + 1));
                assert_eq!(own[..4], [0, 0, 0, sorted[3] + 1]);
                assert!(map(&numbers, &|n| n + 1).iter().zip(&numbers).all(|(n, m)| *n == m + 1));
                assert!(concat(&pieces, &|n, by| n + by) == joined);
                let mut own = numbers[..50_000].to_vec();
                let (a, b) = own.split_at_mut(25_000);
                exchange(a.chunks_mut(7000).collect(), b.chunks_mut(9999).collect());
                assert!(own == exchanged);
            });
        }
    }
}
