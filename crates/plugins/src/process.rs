//! Starts the process of a plugin and runs builds in it.

use std::path::PathBuf;
use std::time::Duration;

/// Settings for starting processes.
#[derive(Debug, Clone)]
pub struct Launch {
    pub program: PathBuf,
    pub file: PathBuf,
    /// Longest time of a build, and of a call that answers rays.
    pub limit: Duration,
    /// A row whose process ended gets a new one.
    pub restarts: bool,
}

pub(crate) struct Order<'a> {
    /// A value for each setting, in their order.
    pub(crate) values: &'a [String],
    /// Threads that build and trace.
    pub(crate) threads: usize,
    /// Most bytes of the structure.
    pub(crate) most_bytes: Option<u64>,
}

/// Result of a build.
pub(crate) enum BuildReply {
    /// It took so many seconds.
    Built(f64),
    Refused(String),
    /// It took so many bytes at least, more than it may; its process was ended.
    TooLarge(u64),
}
