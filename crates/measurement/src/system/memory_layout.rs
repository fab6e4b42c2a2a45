//! Where a fresh process finds its memory, drawn anew for each.
//!
//! A system hands pages that one process gave back to the next one, and a heap that begins alike
//! goes on alike: what processes that follow each other have in common is no chance, and an
//! interval over them does not know of it. So a process that times takes blocks of random sizes
//! first, and gives back a random half: its heap, and the pages below it, are then another draw.
//!
//! Papers: T. Mytkowicz, A. Diwan, M. Hauswirth, P. F. Sweeney, "Producing Wrong Data Without Doing
//! Anything Obviously Wrong!", ASPLOS 2009; C. Curtsinger, E. D. Berger, "Stabilizer: Statistically
//! Sound Performance Evaluation", ASPLOS 2013. Deviations: drawn once for a process, by what the
//! standard library seeds its hash maps with; code and stack stay where the system puts them.

use std::hash::{BuildHasher, RandomState};
use std::hint::black_box;

const BLOCKS: usize = 96;
/// Of that many bytes at most, as a power of two; sizes are drawn evenly by their logarithms.
const LARGEST: f64 = 21.0;
const SMALLEST: f64 = 6.0;
/// One byte of each page is written, so that it is the process's own.
const PAGE: usize = 4096;

/// Blocks to hold, so that all other memory lies elsewhere: another draw each time, some 10 MiB.
pub fn draw() -> Vec<Vec<u8>> {
    let random = RandomState::new();
    // evenly in [0, 1)
    let unit = |i: usize| (random.hash_one(i) >> 11) as f64 / (1u64 << 53) as f64;
    let take = |i: usize| {
        let size = (SMALLEST + (LARGEST - SMALLEST) * unit(i)).exp2() as usize;
        let mut block = vec![0u8; size];
        block.iter_mut().step_by(PAGE).for_each(|byte| *byte = 1);
        black_box(block)
    };
    let blocks: Vec<_> = (0..BLOCKS).map(take).collect();
    let held = blocks.into_iter().enumerate().filter(|(i, _)| unit(BLOCKS + i) < 0.5);
    held.map(|(_, block)| block).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn memory_layouts_differ_between_draws() {
        let bytes = |_| draw().iter().map(Vec::len).sum();
        let mut drawn: Vec<usize> = (0..8).map(bytes).collect();
        assert!(drawn.iter().all(|bytes| (1 << 16..BLOCKS << 21).contains(bytes)), "{drawn:?}");
        drawn.sort_unstable();
        drawn.dedup();
        assert_eq!(drawn.len(), 8, "{drawn:?}");
    }
}
