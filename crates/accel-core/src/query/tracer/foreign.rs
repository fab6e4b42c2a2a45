//! Tracers whose code is not compiled into this program.

/// A structure that comes out of a file, and may answer in a process of its own. Its calls are
/// timed where they are made, so that no way there and back is counted.
///
/// A batch is answered in one call, whatever the number of threads: it divides rays among its own.
pub trait Foreign: Sync {
    /// The origin of the structure.
    fn origin(&self) -> &Origin;
    /// Seconds of the call that built it.
    fn build_seconds(&self) -> f64;
    /// Seconds of the calls that answered rays since this was asked last.
    fn take_seconds(&self) -> f64;
    /// Share of the time of all ray queries spent by threads other than the caller; 0 if unknown.
    fn share_of_other_threads(&self) -> f64;
    /// Why nothing that it answers counts: how its process ended.
    fn failure(&self) -> Option<String>;
    /// Returns whether it counts its work.
    fn has_counters(&self) -> bool;
    /// Returns whether it has several rays of a batch in flight.
    fn answers_batches(&self) -> bool;
}

/// Origin of a foreign structure, and how it is queried.
#[derive(Debug, Clone, PartialEq)]
pub struct Origin {
    /// Name of the file, without folders.
    pub file: String,
    /// SHA-256 of the file, hexadecimal.
    pub sha256: String,
    /// Its version, as it says.
    pub version: String,
    /// Its own triangle test decides: answers differ from those of the set at edges.
    pub has_own_test: bool,
    /// It answers in a process of its own.
    pub own_process: bool,
    /// Seconds of a call that asks for nothing, there and back; not part of any time.
    pub empty_call_s: f64,
}
