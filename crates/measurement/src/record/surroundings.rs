//! What a run was made with and on: the program, the compiler, the machine and how busy it was.

use serde::{Deserialize, Serialize};

#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "testing", derive(schemars::JsonSchema))]
pub struct Tool {
    /// `rtbench`.
    pub name: String,
    /// Package version.
    pub version: String,
    /// Commit it was built from.
    pub git_revision: Option<String>,
}

#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "testing", derive(schemars::JsonSchema))]
pub struct Machine {
    /// Model name of the first processor.
    pub cpu: Option<String>,
    /// Threads the process may use.
    pub threads: usize,
    /// Bytes of memory.
    pub memory_bytes: Option<u64>,
    /// Operating system, with the kernel's release.
    pub os: String,
    /// How the first processor's clock is governed, where that is told.
    #[serde(default)]
    pub governor: Option<String>,
    /// Whether its clock may be raised above its nominal rate, where that is told.
    #[serde(default)]
    pub boost: Option<bool>,
    /// Whether AVX-512 was used, which is chosen where rows run, by those that answer batches and
    /// by `wide-bvh` and `irregular-grid`; records of before do not tell, and those of before 25
    /// November 2026 mean batches alone.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub batches_by_avx512: Option<bool>,
    /// When the system uses huge pages: `always`, `madvise` (for large blocks of the heap, which
    /// ask for them) or `never`. Records of before 27 November 2026 do not tell; their heap did not
    /// ask.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub huge_pages: Option<String>,
}

#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "testing", derive(schemars::JsonSchema))]
pub struct Compiler {
    /// `rustc -V`.
    pub rustc: Option<String>,
    /// Target triple.
    pub target: Option<String>,
    /// Target features.
    pub target_features: Vec<String>,
    /// Cargo profile.
    pub profile: Option<String>,
    /// Optimisation level.
    pub opt_level: Option<String>,
}

/// How busy the machine has been; what counts up does so since its start.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "testing", derive(schemars::JsonSchema))]
pub struct Load {
    /// Mean number of runnable processes in the last minute.
    pub average: Option<f64>,
    /// Processor time of the whole machine; none where it is not told.
    pub ticks: Option<Ticks>,
    /// Pages read back from swap.
    pub pages_swapped_in: Option<u64>,
    /// Bytes of this process that are in swap.
    pub swapped_bytes: Option<u64>,
}

/// Processor time, in the kernel's ticks.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "testing", derive(schemars::JsonSchema))]
pub struct Ticks {
    /// Processors they are counted over.
    pub processors: u64,
    /// All of it, idle or not.
    pub all: u64,
    /// What was used, or taken by the host of a virtual machine.
    pub busy: u64,
    /// What this process used.
    pub own: u64,
}
