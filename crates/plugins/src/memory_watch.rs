//! Watches the memory of a plugin's process during a build.
//!
//! Linux tells the private memory of a process (`RssAnon` in `/proc/PID/status`, proc(5)): what it
//! shares with its parent, the scene and the rays, is not in it. Elsewhere nothing is told, and
//! nothing limited.

use std::net::Shutdown;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

use crate::wire::Stream;

/// How often it is looked at.
const POLL: Duration = Duration::from_millis(10);

/// Private bytes of a process, where the system tells.
fn private_bytes(process: u32) -> Option<u64> {
    let status = std::fs::read_to_string(format!("/proc/{process}/status")).ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("RssAnon:"))?;
    let kibibytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kibibytes << 10)
}

/// Watches a process while it builds, and hangs up on it when it takes `most` bytes more than it
/// has now. What is returned ends the watch, and says how many bytes the process took, if more than
/// allowed; it may have ended since. None where nothing is told.
pub(crate) fn watch(
    process: u32,
    most: u64,
    stream: Stream,
) -> Option<impl FnOnce() -> Option<u64>> {
    let before = private_bytes(process)?;
    let excess = move || {
        let taken = private_bytes(process)?.saturating_sub(before);
        (taken > most).then_some(taken)
    };
    let (ends, ended) = channel::<()>();
    let thread = std::thread::spawn(move || {
        while ended.recv_timeout(POLL) == Err(RecvTimeoutError::Timeout) {
            if let Some(taken) = excess() {
                let _ = stream.shutdown(Shutdown::Both);
                return Some(taken);
            }
        }
        excess()
    });
    Some(move || {
        drop(ends);
        thread.join().ok().flatten()
    })
}
