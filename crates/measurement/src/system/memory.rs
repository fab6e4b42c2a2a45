//! Where the memory of a process lies: in huge pages, and at places that are drawn anew for each
//! process.
//!
//! Where a ray goes from node to node in memory of many megabytes, translations of addresses in
//! small pages are missed in the processor's table, and waited for. Embree asks for huge pages for
//! its own memory; so rows compare fairly only where all have them. Linux has them for who asks
//! where `/sys/kernel/mm/transparent_hugepage/enabled` says `madvise`, for all where it says
//! `always`.
//!
//! A system hands pages that one process gave back to the next one, and a heap that begins alike
//! goes on alike: what processes that follow each other have in common is no chance, and an
//! interval over them does not know of it. So a process that times takes blocks of random sizes
//! first, and gives back a random half: its heap, and the pages below it, are then another draw.
//!
//! Papers: T. Mytkowicz, A. Diwan, M. Hauswirth, P. F. Sweeney, "Producing Wrong Data Without Doing
//! Anything Obviously Wrong!", ASPLOS 2009; C. Curtsinger, E. D. Berger, "Stabilizer: Statistically
//! Sound Performance Evaluation", ASPLOS 2013. Deviations: drawn once for a process, by what the
//! standard library seeds its hash maps with; code and stack stay where the system puts them, where
//! loops over rays align their frames.

use std::alloc::{GlobalAlloc, Layout, System};
use std::hash::{BuildHasher, RandomState};
use std::hint::black_box;

/// The system's allocator; asks for huge pages for large blocks.
pub struct HugePageHeap;

/// Bytes of a huge page on x86-64 and most of ARM.
const HUGE_PAGE: usize = 2 << 20;

/// Asks that the huge pages that lie wholly within a block be used for it. A system that has none
/// ignores this.
fn advise(block: *mut u8, size: usize) {
    #[cfg(target_os = "linux")]
    if size >= HUGE_PAGE && !block.is_null() {
        let skipped = block.align_offset(HUGE_PAGE);
        let whole = size.saturating_sub(skipped) / HUGE_PAGE * HUGE_PAGE;
        if whole > 0 {
            let start = block.wrapping_add(skipped).cast();
            let advice = rustix::mm::Advice::LinuxHugepage;
            // SAFETY: the pages lie in a block that is ours, and what is in them stays as it is
            let _ = unsafe { rustix::mm::madvise(start, whole, advice) };
        }
    }
    #[cfg(not(target_os = "linux"))]
    let _ = (block, size);
}

// SAFETY: all blocks are those of `System`, which is asked with the caller's own arguments
unsafe impl GlobalAlloc for HugePageHeap {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        // SAFETY: as the caller has it
        let block = unsafe { System.alloc(layout) };
        advise(block, layout.size());
        block
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        // SAFETY: as the caller has it
        let block = unsafe { System.alloc_zeroed(layout) };
        advise(block, layout.size());
        block
    }

    unsafe fn realloc(&self, block: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        // SAFETY: as the caller has it
        let block = unsafe { System.realloc(block, layout, size) };
        advise(block, size);
        block
    }

    unsafe fn dealloc(&self, block: *mut u8, layout: Layout) {
        // SAFETY: as the caller has it
        unsafe { System.dealloc(block, layout) }
    }
}

/// The word in brackets of the system's file: when it uses huge pages.
pub fn huge_pages_in(file: &str) -> Option<String> {
    let (_, rest) = file.split_once('[')?;
    Some(rest.split_once(']')?.0.to_owned())
}

const BLOCKS: usize = 96;
/// Of that many bytes at most, as a power of two; sizes are drawn evenly by their logarithms.
const LARGEST: f64 = 21.0;
const SMALLEST: f64 = 6.0;
/// One byte of each page is written, so that it is the process's own.
const PAGE: usize = 4096;

/// Blocks to hold, so that all other memory lies elsewhere: another draw each time, some 10 MiB.
pub fn draw_layout() -> Vec<Vec<u8>> {
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
    fn blocks_of_all_sizes_keep_what_is_in_them() {
        for size in [1, 4096, HUGE_PAGE - 1, HUGE_PAGE, 3 * HUGE_PAGE + 5] {
            let layout = Layout::from_size_align(size, 64).unwrap();
            let larger = Layout::from_size_align(4 * size, 64).unwrap();
            // SAFETY: sizes are not zero; what is read was written
            unsafe {
                let block = HugePageHeap.alloc(layout);
                block.write_bytes(7, size);
                let block = HugePageHeap.realloc(block, layout, larger.size());
                assert_eq!(block.addr() % 64, 0);
                assert!(std::slice::from_raw_parts(block, size).iter().all(|byte| *byte == 7));
                HugePageHeap.dealloc(block, larger);
                let block = HugePageHeap.alloc_zeroed(layout);
                assert!(std::slice::from_raw_parts(block, size).iter().all(|byte| *byte == 0));
                HugePageHeap.dealloc(block, layout);
            }
        }
    }

    #[test]
    fn the_word_in_brackets_counts() {
        assert_eq!(huge_pages_in("always [madvise] never\n").as_deref(), Some("madvise"));
        assert_eq!(huge_pages_in(""), None);
    }

    #[test]
    fn memory_layouts_differ_between_draws() {
        let bytes = |_| draw_layout().iter().map(Vec::len).sum();
        let mut drawn: Vec<usize> = (0..8).map(bytes).collect();
        assert!(drawn.iter().all(|bytes| (1 << 16..BLOCKS << 21).contains(bytes)), "{drawn:?}");
        drawn.sort_unstable();
        drawn.dedup();
        assert_eq!(drawn.len(), 8, "{drawn:?}");
    }
}
