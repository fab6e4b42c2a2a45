//! Record of an animation.

use measurement::record::{Compiler, Machine, OracleRecord, Tool, WorkRecord};
use serde::Serialize;

#[derive(Debug, Clone, Default, Serialize)]
pub struct AnimationRecord {
    pub tool: Tool,
    /// The command line, program first.
    pub command_line: Vec<String>,
    /// The machine of the run.
    pub machine: Machine,
    /// Compiler and flags of the program.
    pub compiler: Compiler,
    /// Name of the scene.
    pub scene: String,
    /// Structures of a row, each updated and timed.
    pub rounds: usize,
    /// Seed of orders and samples.
    pub seed: u64,
    /// Pixels of the image whose rays are asked.
    pub resolution: [u32; 2],
    pub precision: String,
    pub kinds: Vec<String>,
    /// The whole, seconds.
    pub took_s: f64,
    /// All frames asked for were measured.
    pub complete: bool,
    /// The frames, in their order.
    pub frames: Vec<FrameRecord>,
    /// The rows, each with a number of threads.
    pub lanes: Vec<LaneRecord>,
}

#[derive(Debug, Clone, Serialize)]
pub struct FrameRecord {
    pub frame: u32,
    pub primitives: u64,
    /// Number of these that changed since the previous frame; `None` in the first, and if the sets
    /// of primitives differ.
    pub moved: Option<u64>,
    /// Rays of all kinds.
    pub rays: u64,
    /// How the right answers were found.
    pub oracle: OracleRecord,
}

/// A row with a number of threads.
#[derive(Debug, Clone, Default, Serialize)]
pub struct LaneRecord {
    pub structure: String,
    /// Settings that differ from the defaults.
    pub settings: String,
    /// Threads that update and trace.
    pub threads: usize,
    pub known_defect: Option<String>,
    /// Why it ended early.
    pub error: Option<String>,
    /// Wrong answers in all frames.
    pub mismatches: u64,
    /// The first of them.
    pub example: Option<String>,
    /// Stride of the rays that were timed.
    pub stride: usize,
    pub frames: Vec<LaneFrame>,
}

/// A row in a frame.
#[derive(Debug, Clone, Default, Serialize)]
pub struct LaneFrame {
    /// Number of the frame.
    pub frame: u32,
    /// Number of rounds that updated it; the others rebuilt it.
    pub updated: usize,
    /// Seconds of the update or build, a round each.
    pub update_s: Vec<f64>,
    /// Seconds of all rays, a round each; where every n-th ray was timed, n times what they took.
    pub trace_s: Vec<f64>,
    /// Bytes of the structure.
    pub bytes: u64,
    /// The work of the counting pass; with one thread alone.
    pub work: Option<WorkRecord>,
    /// Expected steps and tests of a ray; with one thread alone: see [`crate::animate::quality`].
    pub expected_cost: Option<f64>,
    pub overlap: Option<f64>,
}
