//! The noise score of `rtbench doctor`: the same short loop many times over, and how far its times
//! lie apart.
//!
//! The loop does nothing but arithmetic in registers, so that neither caches nor memory have a
//! part in it: what differs is the clock frequency, and what else ran on the core.

use std::hint::black_box;

use serde::Serialize;

use crate::system::clock::Clock;
use statistics::estimate::quantile;

const LOOPS: usize = 100;
/// Seconds that a loop should take: long against a reading of the clock, short against a slice of
/// the scheduler.
const SECONDS: f64 = 2e-3;
/// Rounds of the loop that calibration begins and ends with.
const CALIBRATION: [u64; 2] = [1 << 12, 1 << 24];
const QUIET: f64 = 0.01;

#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Noise {
    loops: usize,
    /// Median time of a loop, seconds.
    loop_s: f64,
    /// Width of the middle half of the times, over the median: the noise score.
    spread: f64,
    /// By how much the slowest loop was slower than the median, over the median.
    slowest: f64,
}

/// SplitMix64's step, over and over: each waits for the one before.
fn work(rounds: u64) -> u64 {
    // no iterator: where nothing is optimised, as in tests, that is ten times the work
    let (mut x, mut i) = (1u64, 0);
    while i < rounds {
        x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb) ^ i;
        i += 1;
    }
    x
}

impl Noise {
    pub fn measured(clock: &dyn Clock) -> Self {
        let timed = |rounds: u64| {
            let start = clock.now();
            black_box(work(black_box(rounds)));
            clock.seconds_since(start)
        };
        let [mut rounds, most] = CALIBRATION;
        while rounds < most && timed(rounds) < SECONDS {
            rounds *= 2;
        }
        let seconds: Vec<f64> = (0..LOOPS).map(|_| timed(rounds)).collect();
        Self::of(seconds)
    }

    fn of(mut seconds: Vec<f64>) -> Self {
        seconds.sort_by(f64::total_cmp);
        let quartiles = [0.25, 0.5, 0.75, 1.0].map(|part| quantile(&seconds, part));
        let [low, loop_s, high, longest] = quartiles;
        let over = |x: f64| if loop_s > 0.0 { x / loop_s } else { 0.0 };
        let (spread, slowest) = (over(high - low), over(longest - loop_s));
        Self { loops: seconds.len(), loop_s, spread, slowest }
    }

    /// Returns whether the machine is quiet, and the score in words.
    pub fn judged(&self) -> (bool, String) {
        let words = format!(
            "{:.2}% (the middle half of {} loops of {:.2} ms), the slowest {:.0}% slower",
            100.0 * self.spread,
            self.loops,
            1e3 * self.loop_s,
            100.0 * self.slowest
        );
        (self.spread <= QUIET, words)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_that_lie_apart_are_a_warning() {
        let times = (0..100).map(|i| if i % 3 == 0 { 1.2 } else { 1.0 }).chain([3.0]).collect();
        let noise = Noise::of(times);
        assert!((noise.spread - 0.2).abs() < 1e-12 && (noise.slowest - 2.0).abs() < 1e-12);
        let (is_quiet, words) = noise.judged();
        assert!(!is_quiet && words.starts_with("20.00%"), "{words}");
        // one slow loop alone is no reason: medians do not see it
        let times = std::iter::repeat_n(1.0, 99).chain([9.0]).collect();
        assert!(Noise::of(times).judged().0);
    }

    #[test]
    fn the_loop_is_not_optimised_away() {
        assert_ne!(work(10), work(11));
    }
}
