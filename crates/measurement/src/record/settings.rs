//! What a run was asked for, and what it was made with and on: the program, the compiler, the machine
//! and how busy it was.

use serde::{Deserialize, Serialize};

use crate::rays::order::Orders;
use crate::scenes::ViewOptions;
use crate::settings::Lights;

/// Settings of a run.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "testing", derive(schemars::JsonSchema))]
pub struct Settings {
    /// Seed of schedules, samples, directions and intervals.
    pub seed: u64,
    /// Threads that built and traced.
    pub threads: usize,
    /// `f32` or `f64`.
    pub precision: String,
    /// Pixels of the image.
    pub resolution: [u32; 2],
    /// Longest chain of closest-hit rays.
    pub max_depth: u32,
    /// Kinds of rays.
    pub rays: Vec<String>,
    /// The reference row of ratios, in every scene where it was built and is right; see
    /// `is_reference` of the rows.
    pub reference: String,
    /// Run with `--quick`.
    pub quick: bool,
    /// In which order rays were issued to rows: `scanline`, `shuffled`, or `both`.
    #[serde(default = "scanline")]
    pub order: String,
    /// Which lights were asked: `each` that a hit faces, or from primary hits the `first`.
    #[serde(default = "each_light")]
    pub lights: String,
    /// What the command line said of the view and the lights of all scenes; absent where it said
    /// nothing.
    #[serde(default, skip_serializing_if = "ViewOptions::is_empty")]
    pub view: ViewOptions,
    /// Tables of each kind of ray, and of the time to a picture, were asked for.
    #[serde(default)]
    pub by_kind: bool,
    /// Processes in which rows were built and timed, each scene in each of them.
    #[serde(default = "one")]
    pub processes: u32,
    /// What times are: `processor time` of the thread that builds and traces, where that is one;
    /// else `time of day`.
    #[serde(default = "time_of_day")]
    pub timed_by: String,
}

/// Of records from before threads were timed by their own time.
fn time_of_day() -> String {
    TIME_OF_DAY.to_owned()
}

/// What a run of one thread is timed by.
pub const PROCESSOR_TIME: &str = "processor time";
pub const TIME_OF_DAY: &str = "time of day";

/// Of records from before there could be more.
fn one() -> u32 {
    1
}

/// Of records from before there were orders.
fn scanline() -> String {
    Orders::Scanline.name().to_owned()
}

/// Of records from before lights could be chosen.
fn each_light() -> String {
    Lights::Each.name().to_owned()
}

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
