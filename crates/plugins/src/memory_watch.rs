//! Watches the memory of a plugin's process during a build.
//!
//! Linux tells the private memory of a process (`RssAnon` in `/proc/PID/status`, proc(5)): what it
//! shares with its parent, the scene and the rays, is not in it. Elsewhere nothing is told, and
//! nothing limited.

use std::net::Shutdown;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering::SeqCst};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use std::time::Duration;

use crate::wire::Stream;

/// How often it is looked at.
const POLL: Duration = Duration::from_millis(10);

/// Private bytes of a process, where the system tells.
pub(crate) fn private_bytes(process: u32) -> Option<u64> {
    let status = std::fs::read_to_string(format!("/proc/{process}/status")).ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("RssAnon:"))?;
    let kibibytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kibibytes << 10)
}

/// Looks at a process while it builds, and hangs up on it when it takes too much.
pub(crate) struct MemoryWatch {
    /// Dropped when the build has ended.
    ends: Sender<()>,
    thread: JoinHandle<()>,
    excess: Arc<AtomicU64>,
    process: u32,
    before: u64,
    most: u64,
}

impl MemoryWatch {
    /// Watches until [`MemoryWatch::excess`]: `most` bytes more than now may be taken. None where
    /// nothing is told.
    pub(crate) fn begin(process: u32, most: u64, stream: Stream) -> Option<Self> {
        let before = private_bytes(process)?;
        let (ends, ended): (_, Receiver<()>) = channel();
        let excess = Arc::new(AtomicU64::new(0));
        let seen = Arc::clone(&excess);
        let thread = std::thread::spawn(move || {
            while ended.recv_timeout(POLL) == Err(RecvTimeoutError::Timeout) {
                let taken = private_bytes(process).map_or(0, |bytes| bytes.saturating_sub(before));
                if taken > most {
                    seen.store(taken, SeqCst);
                    let _ = stream.shutdown(Shutdown::Both);
                    return;
                }
            }
        });
        Some(Self { ends, thread, excess, process, before, most })
    }

    /// Bytes that it took, if more than allowed; the process may have ended since.
    pub(crate) fn excess(self) -> Option<u64> {
        drop(self.ends);
        let _ = self.thread.join();
        let seen = self.excess.load(SeqCst);
        let after = private_bytes(self.process).unwrap_or_default().saturating_sub(self.before);
        Some(seen.max(after)).filter(|bytes| *bytes > self.most)
    }
}
