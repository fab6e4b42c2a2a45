//! The threads: those that are measured, and those that check.

use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::rounds::MeasureError;
use crate::system::machine;

/// Two pools, so that checking may use the whole machine whatever is measured.
#[derive(Debug)]
pub struct Pools {
    /// Builds and timed passes run here: `-j` threads.
    pub measured: ThreadPool,
    /// Ray generation, checking and counting run here: all threads of the machine.
    pub helper: ThreadPool,
}

impl Pools {
    pub fn new(threads: usize) -> Result<Self, MeasureError> {
        Ok(Self { measured: pool(threads)?, helper: pool(machine::threads())? })
    }
}

pub fn pool(threads: usize) -> Result<ThreadPool, MeasureError> {
    started(ThreadPoolBuilder::new(), threads)
}

/// Bytes of stack that [`deep_pool`] reserves a thread; only what is used takes memory.
const DEEP: usize = 256 << 20;

/// The same with deep stacks: obvhs as shipped recurses once a level, and builds a level for each
/// of ten thousand equal boxes. On a usual stack that ends the process.
pub fn deep_pool(threads: usize) -> Result<ThreadPool, MeasureError> {
    started(ThreadPoolBuilder::new().stack_size(DEEP), threads)
}

fn started(builder: ThreadPoolBuilder, threads: usize) -> Result<ThreadPool, MeasureError> {
    builder.num_threads(threads).build().map_err(|source| MeasureError::Threads { threads, source })
}
