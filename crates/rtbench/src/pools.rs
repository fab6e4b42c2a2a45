//! The threads: those that are measured, and those that check.

use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::error::Error;
use crate::machine;

/// Two pools, so that checking may use the whole machine whatever is measured.
#[derive(Debug)]
pub struct Pools {
    /// Builds and timed passes run here: `-j` threads.
    pub measured: ThreadPool,
    /// Ray generation, checking and counting run here: all threads of the machine.
    pub helper: ThreadPool,
}

impl Pools {
    /// Starts them.
    ///
    /// # Errors
    /// [`Error::Threads`].
    pub fn new(threads: usize) -> Result<Self, Error> {
        Ok(Self { measured: pool(threads)?, helper: pool(machine::threads())? })
    }
}

/// A pool of that many threads.
///
/// # Errors
/// [`Error::Threads`].
pub fn pool(threads: usize) -> Result<ThreadPool, Error> {
    ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .map_err(|source| Error::Threads { threads, source })
}
