//! How long a load takes that waits for the one before it, by the size of the memory that is used.
//!
//! Source: L. McVoy, C. Staelin, "lmbench: Portable Tools for Performance Analysis", USENIX 1996: each
//! line of memory names the next one, in an order that no prefetcher guesses. The order is one cycle
//! through all lines (S. Sattolo, "An Algorithm to Generate a Random Cyclic Permutation", Information
//! Processing Letters 22(6), 1986). What a page table costs is in the times, as it is in a structure's.

use std::hint::black_box;

use serde::Serialize;

use measurement::system::clock::Clock;
use statistics::random::Random;

/// The sizes of `rtbench doctor --memory`, bytes.
pub const SIZES: [usize; 10] = [
    16 << 10,
    128 << 10,
    256 << 10,
    512 << 10,
    1 << 20,
    4 << 20,
    8 << 20,
    16 << 20,
    64 << 20,
    256 << 20,
];
/// Bytes of a line of the caches of all processors that this is likely to run on.
pub const LINE: usize = 64;
/// Loads of a pass: long against a reading of the clock, short against a slice of the scheduler.
const LOADS: usize = 1 << 16;
/// Passes, of which the shortest counts, as in lmbench: what disturbs a pass makes it longer.
const PASSES: usize = 32;

/// What a size gave.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Latency {
    /// Bytes among which loads were spread.
    pub bytes: usize,
    /// Seconds of a load.
    pub load_s: f64,
}

/// A line of memory that names the next.
#[repr(align(64))]
#[derive(Clone, Copy)]
struct Line {
    next: u32,
}

/// Times loads among each of the sizes.
pub fn measure(sizes: &[usize], clock: &dyn Clock) -> Vec<Latency> {
    sizes.iter().map(|&bytes| Latency { bytes, load_s: load_s(bytes, clock) }).collect()
}

/// Seconds of a load among so many bytes.
fn load_s(bytes: usize, clock: &dyn Clock) -> f64 {
    let lines = cycle(bytes / LINE);
    // one round or pass that is not timed brings into the caches what they hold
    let mut at = black_box(walk(&lines, 0, LOADS.max(lines.len())));
    let passes = (0..PASSES).map(|_| {
        let start = clock.now();
        at = black_box(walk(&lines, at, LOADS));
        clock.seconds_since(start)
    });
    passes.min_by(f64::total_cmp).unwrap_or(0.0) / LOADS as f64
}

/// Lines in one random cycle; at least one.
fn cycle(lines: usize) -> Vec<Line> {
    let mut next: Vec<Line> = (0..lines.max(1) as u32).map(|next| Line { next }).collect();
    let mut random = Random::new(1, "memory");
    for last in (1..next.len()).rev() {
        next.swap(last, random.below(last));
    }
    next
}

/// Where so many loads lead.
#[inline(never)]
fn walk(lines: &[Line], from: u32, loads: usize) -> u32 {
    (0..loads).fold(from, |at, _| lines.get(at as usize).map_or(0, |line| line.next))
}

/// The time of a load among so many bytes, between those of the sizes around it; none without sizes.
pub fn interpolated(latencies: &[Latency], bytes: f64) -> Option<f64> {
    let above = latencies.iter().position(|l| l.bytes as f64 >= bytes);
    let (low, high) = match above {
        Some(0) => return latencies.first().map(|l| l.load_s),
        None => return latencies.last().map(|l| l.load_s),
        Some(i) => (latencies.get(i - 1)?, latencies.get(i)?),
    };
    let [a, b] = [low, high].map(|l| (l.bytes as f64).ln());
    let share = (bytes.ln() - a) / (b - a);
    Some(low.load_s + share * (high.load_s - low.load_s))
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;
    use measurement::system::clock::SteppingClock;

    #[test]
    fn the_walk_comes_by_every_line_once() {
        for lines in [1, 2, 3, 64, 1000] {
            let next = cycle(lines);
            let mut seen = vec![false; lines];
            let mut at = 0;
            for _ in 0..lines {
                assert!(!std::mem::replace(&mut seen[at as usize], true), "{lines}: no cycle");
                at = walk(&next, at, 1);
            }
            assert!(at == 0 && seen.iter().all(|s| *s));
        }
        assert_eq!(size_of::<Line>(), LINE);
    }

    #[test]
    fn a_load_is_a_pass_over_its_loads() {
        let clock = SteppingClock::new(Duration::from_millis(2));
        let found = measure(&[1 << 10, 1 << 12], &clock);
        assert_eq!(found.iter().map(|l| l.bytes).collect::<Vec<_>>(), [1 << 10, 1 << 12]);
        assert!(found.iter().all(|l| (l.load_s - 2e-3 / LOADS as f64).abs() < 1e-15), "{found:?}");
    }

    #[test]
    fn sizes_in_between_are_interpolated() {
        let of = |bytes, load_s| Latency { bytes, load_s };
        let known = [of(1 << 10, 1e-9), of(1 << 12, 3e-9)];
        for (bytes, expected) in [(512.0, 1e-9), (2048.0, 2e-9), (4096.0, 3e-9), (1e9, 3e-9)] {
            let found = interpolated(&known, bytes).unwrap();
            assert!((found - expected).abs() < 1e-15, "{bytes}: {found}");
        }
        assert_eq!(interpolated(&[], 1.0), None);
    }
}
