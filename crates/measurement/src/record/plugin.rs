//! Where a row comes from whose code is not of this program.

use accel_core::query::tracer::Foreign;
use serde::{Deserialize, Serialize};

/// The plugin that a row is of.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "testing", derive(schemars::JsonSchema))]
pub struct PluginRecord {
    /// Name of the file, without folders.
    pub file: String,
    /// SHA-256 of the file.
    pub sha256: String,
    /// Its version, as it says.
    pub version: String,
    /// It answered in a process of its own; else in that of the run.
    pub own_process: bool,
    /// Its own triangle test decided; else that of this program, and answers are compared bit by bit.
    pub own_test: bool,
    /// Seconds of a call that asks for nothing, to its process and back. Part of no time.
    pub empty_call_s: f64,
    /// With one thread, the part of its time that threads other than the one that asked had, while its answers
    /// were checked. It counts.
    #[serde(default)]
    pub other_threads: f64,
    /// Rays that were answered otherwise than expected where rounding decides, of the checked ones.
    pub edge_mismatches: u64,
}

impl PluginRecord {
    /// Of a row that answered so many rays otherwise at edges.
    pub fn new(foreign: &dyn Foreign, edge_mismatches: u64) -> Self {
        let origin = foreign.origin();
        Self {
            file: origin.file.clone(),
            sha256: origin.sha256.clone(),
            version: origin.version.clone(),
            own_process: origin.own_process,
            own_test: origin.has_own_test,
            empty_call_s: origin.empty_call_s,
            other_threads: foreign.share_of_other_threads(),
            edge_mismatches,
        }
    }
}

/// What is known of a row whose times its program told.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "testing", derive(schemars::JsonSchema))]
pub struct ForeignRecord {
    /// SHA-256 of the file of its answers.
    pub hits_sha256: String,
    /// Rays that were answered otherwise than expected where rounding decides, of the checked ones.
    pub edge_mismatches: u64,
}
