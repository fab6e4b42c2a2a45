//! How far the loader is that runs now, for whoever shows it.
//!
//! One pair of counters for the process: scenes are loaded one after the other, and a bar that is
//! briefly wrong hurts nobody. Loaders tell about once a megabyte, so it costs them nothing.

use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

static DONE: AtomicU64 = AtomicU64::new(0);
static TOTAL: AtomicU64 = AtomicU64::new(0);

/// The share of the current stage of loading that is done, in [0, 1]; none when nothing is loaded.
pub fn share() -> Option<f64> {
    let (done, total) = (DONE.load(Relaxed), TOTAL.load(Relaxed));
    (total > 0).then(|| (done as f64 / total as f64).min(1.0))
}

/// A stage of that many bytes or elements begins.
pub(crate) fn begin(total: usize) {
    DONE.store(0, Relaxed);
    TOTAL.store(total as u64, Relaxed);
}

/// So many of them are done.
pub(crate) fn at(done: usize) {
    DONE.store(done as u64, Relaxed);
}

/// One more of many is done, the `i`-th; told once for 65,536 of them.
pub(crate) fn step(i: usize) {
    if i.is_multiple_of(1 << 16) {
        at(i);
    }
}

/// The stage is over.
pub(crate) fn end() {
    begin(0);
}
