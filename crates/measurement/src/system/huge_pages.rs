//! The heap, whose large blocks the system may keep in huge pages: where a ray goes from node to
//! node in memory of many megabytes, translations of addresses in small pages are missed in the
//! processor's table, and waited for. Embree asks for huge pages for its own memory; so rows
//! compare fairly only where all have them.
//!
//! Linux has them for who asks where `/sys/kernel/mm/transparent_hugepage/enabled` says `madvise`,
//! for all where it says `always`.

use std::alloc::{GlobalAlloc, Layout, System};

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
pub fn use_of(file: &str) -> Option<String> {
    let (_, rest) = file.split_once('[')?;
    Some(rest.split_once(']')?.0.to_owned())
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
        assert_eq!(use_of("always [madvise] never\n").as_deref(), Some("madvise"));
        assert_eq!(use_of(""), None);
    }
}
