//! The record of a run: everything that tables, CSV and plots are made from, and what JSON holds.

pub mod file;
pub mod label;
#[cfg(any(test, feature = "testing"))]
#[allow(clippy::unwrap_used)]
pub mod made_up;
pub mod merge;
pub mod metrics;
pub mod query;
pub mod ratios;
pub mod reference;
pub mod scale;
pub mod summary;
pub mod surroundings;
pub mod warning;
pub mod warnings;

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::rays::order::{Orders, distinct};
use crate::record::query::Query;
use crate::settings::Lights;
use crate::settings::shard::ShardRecord;
use statistics::estimate::Estimate;
use statistics::outliers::outliers;

pub use label::label;
pub use scale::ScaleRecord;
pub use surroundings::{Compiler, Load, Machine, Ticks, Tool};
pub use warning::Warning;

/// Version of this schema; raised when a field changes its meaning or goes away.
pub const SCHEMA_VERSION: u32 = 1;

/// A run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "testing", derive(schemars::JsonSchema))]
pub struct RunRecord {
    /// Version of this schema: 1. Raised when a field changes its meaning or goes away, not for new
    /// ones.
    pub schema_version: u32,
    /// What was run.
    pub tool: Tool,
    /// The command line, program first.
    pub command_line: Vec<String>,
    /// When it began, seconds since 1970.
    pub started_unix_s: u64,
    /// What it ran on.
    pub machine: Machine,
    /// What it was compiled with.
    pub compiler: Compiler,
    /// What was asked for.
    pub settings: Settings,
    /// One for each finished scene.
    pub scenes: Vec<SceneRecord>,
    /// Over all finished scenes, one for each row.
    pub summary: Vec<SummaryRow>,
    /// Largest resident set of the process so far, bytes.
    pub peak_rss_bytes: Option<u64>,
    /// The scenes asked for, finished or not; empty in records from before there was a journal.
    #[serde(default)]
    pub planned: Vec<String>,
    /// Every scene had its turn; false in what a killed or interrupted run leaves.
    #[serde(default = "from_before")]
    pub complete: bool,
    /// How busy the machine was before the run and after it.
    #[serde(default)]
    pub load: [Load; 2],
    /// What makes the figures less certain than they look.
    #[serde(default)]
    pub warnings: Vec<Warning>,
    /// Which part of a run it is, where the run was divided by `--shard`.
    #[serde(default)]
    pub shard: Option<ShardRecord>,
    /// The parts that it was joined of; empty unless `rtbench merge` made it.
    #[serde(default)]
    pub parts: Vec<PartRecord>,
    /// The sizes and slopes, where the scenes are the sizes of one (`rtbench scale`).
    #[serde(default)]
    pub scale: Option<ScaleRecord>,
}

/// A part that a run was joined of.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "testing", derive(schemars::JsonSchema))]
pub struct PartRecord {
    /// Which part, from 1.
    pub index: u32,
    /// Its command line, program first.
    pub command_line: Vec<String>,
    /// What it ran on.
    pub machine: Machine,
    /// When it began, seconds since 1970.
    pub started_unix_s: u64,
}

/// Of records from before there was a journal.
fn from_before() -> bool {
    true
}

/// Settings of a run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
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
    /// The row that ratios are taken to, in every scene where it was built and is right; see
    /// `is_reference` of the rows.
    pub reference: String,
    /// Run with `--quick`.
    pub quick: bool,
    /// In which order rows were asked the rays: `scanline`, `shuffled`, or `both`.
    #[serde(default = "scanline")]
    pub order: String,
    /// Which lights were asked: `each` that a hit faces, or from primary hits the `first`.
    #[serde(default = "each_light")]
    pub lights: String,
    /// Tables of each kind of ray, and of the time to a picture, were asked for.
    #[serde(default)]
    pub by_kind: bool,
}

/// Of records from before there were orders.
fn scanline() -> String {
    Orders::Scanline.name().to_owned()
}

/// Of records from before lights could be chosen.
fn each_light() -> String {
    Lights::Each.name().to_owned()
}

/// A scene's results.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "testing", derive(schemars::JsonSchema))]
pub struct SceneRecord {
    /// Name.
    pub name: String,
    /// Hash of the source.
    pub sha256: String,
    /// Where it comes from.
    pub source: String,
    /// Under which licence, where known.
    pub licence: Option<String>,
    /// Number of primitives.
    pub primitives: u64,
    /// Bytes of the primitives, without structures.
    pub geometry_bytes: u64,
    /// What the loader noticed.
    pub warnings: Vec<String>,
    /// Rays of each kind; those in shuffled order by `KIND-shuffled`, here and in all rows.
    pub rays: BTreeMap<String, u64>,
    /// How answers were judged.
    pub oracle: OracleRecord,
    /// One for each structure and setting.
    pub rows: Vec<RowRecord>,
    /// Largest resident set while the scene was measured, bytes.
    pub peak_rss_bytes: Option<u64>,
}

/// How the answers of a scene were judged.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "testing", derive(schemars::JsonSchema))]
pub struct OracleRecord {
    /// The row whose answers all others are compared with; none when the oracle confirmed none.
    pub reference: Option<String>,
    /// Structures that the oracle refused as reference, with an example each.
    pub refused: Vec<String>,
    /// Rays of the reference that were compared with f64 brute force.
    pub checked: u64,
    /// Of those, borderline rays: rounding alone decides their answer (see `oracle.rs`).
    pub borderline: u64,
    /// The same for each kind of ray: checked, borderline.
    pub by_kind: BTreeMap<String, [u64; 2]>,
}

/// Which rays a row answers.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "testing", derive(schemars::JsonSchema))]
pub enum Answered {
    /// Rays of every kind: a structure.
    #[default]
    #[serde(rename = "all rays")]
    AllRays,
    /// Shadow rays only: an occluder. Its times and ratios are over these.
    #[serde(rename = "shadow rays")]
    ShadowRays,
}

impl Answered {
    /// As printed.
    pub fn name(self) -> &'static str {
        match self {
            Self::AllRays => "all rays",
            Self::ShadowRays => "shadow rays",
        }
    }
}

/// What is said of a row.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "testing", derive(schemars::JsonSchema))]
pub enum Verdict {
    /// Every answer agrees.
    #[serde(rename = "ok")]
    Ok,
    /// Some answer is wrong: its times are not shown.
    #[serde(rename = "wrong")]
    Wrong,
    /// Some answer is wrong, by a defect that the setting keeps on purpose.
    #[serde(rename = "wrong (as shipped)")]
    WrongAsShipped,
    /// It refused to be built over this scene.
    #[serde(rename = "not built")]
    NotBuilt,
    /// It panicked while it was built, checked or timed, or ended the program.
    #[serde(rename = "panicked")]
    Panicked,
    /// Building it takes more time or memory than it may, at this size or at a smaller one.
    #[serde(rename = "over limit")]
    OverLimit,
    /// It would take more memory than there is for it, by `--max-memory` or by the system.
    #[serde(rename = "out of memory")]
    OutOfMemory,
}

impl Verdict {
    /// As printed.
    pub fn name(self) -> &'static str {
        match self {
            Self::Ok => "ok",
            Self::Wrong => "wrong",
            Self::WrongAsShipped => "wrong (as shipped)",
            Self::NotBuilt => "not built",
            Self::Panicked => "panicked",
            Self::OverLimit => "over limit",
            Self::OutOfMemory => "out of memory",
        }
    }

    /// True when there was something to judge; else `error` says why not.
    pub fn is_judged(self) -> bool {
        matches!(self, Self::Ok | Self::Wrong | Self::WrongAsShipped)
    }

    /// True when its times may be shown.
    pub fn is_timed(self) -> bool {
        matches!(self, Self::Ok | Self::WrongAsShipped)
    }
}

/// What was built, in the symbols of Havran and Sixta (1999).
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "testing", derive(schemars::JsonSchema))]
pub struct ShapeRecord {
    /// N_IN: hierarchical cells.
    pub n_in: u64,
    /// N_V: elementary cells.
    pub n_v: u64,
    /// N_EV: empty elementary cells.
    pub n_ev: u64,
    /// N_OIV: references in elementary cells.
    pub n_oiv: u64,
    /// Voxels an axis.
    pub resolution: Option<[u32; 3]>,
    /// Bytes of the structure.
    pub memory_bytes: u64,
    /// Structures that build on demand: cells that no ray of the counting pass had divided.
    #[serde(default)]
    pub pending_cells: Option<u64>,
}

/// Work of all counted rays together.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "testing", derive(schemars::JsonSchema))]
pub struct WorkRecord {
    /// Rays counted over.
    pub rays: u64,
    /// N_IT: intersection tests.
    pub intersection_tests: u64,
    /// N_TS: traversal steps.
    pub traversal_steps: u64,
    /// N_ETS: elementary steps.
    pub elementary_steps: u64,
    /// N_EETS: empty elementary steps.
    pub empty_elementary_steps: u64,
    /// Tests that a mailbox spared.
    #[serde(default)]
    pub tests_saved: u64,
}

impl WorkRecord {
    /// The part of all tests that a mailbox spared; none where it spared none.
    pub fn saved_part(&self) -> Option<f64> {
        let all = self.tests_saved + self.intersection_tests;
        (self.tests_saved > 0).then(|| self.tests_saved as f64 / all as f64)
    }

    /// N_IT, N_TS, N_ETS, N_EETS per ray.
    pub fn per_ray(&self) -> [f64; 4] {
        let rays = self.rays.max(1) as f64;
        [
            self.intersection_tests,
            self.traversal_steps,
            self.elementary_steps,
            self.empty_elementary_steps,
        ]
        .map(|n| n as f64 / rays)
    }
}

/// One visit of a row.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "testing", derive(schemars::JsonSchema))]
pub struct Sample {
    /// Round, from 0.
    pub round: u32,
    /// Position within the round, from 0.
    pub position: u32,
    /// Seconds of the build.
    pub build_s: f64,
    /// Seconds of each kind of ray.
    pub trace_s: BTreeMap<String, f64>,
    /// Seconds that the reference row took for the same rays in the same round.
    pub reference_trace_s: Option<f64>,
    /// Seconds of the reference row's build in the same round. None in records from before.
    #[serde(default)]
    pub reference_build_s: Option<f64>,
    /// What `reference_trace_s` is the sum of, by kind. Empty in records from before.
    #[serde(default)]
    pub reference_by_kind: BTreeMap<String, f64>,
}

impl Sample {
    /// Seconds of all kinds.
    pub fn total_trace_s(&self) -> f64 {
        self.trace_s.values().sum()
    }
}

/// A structure with settings on a scene.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "testing", derive(schemars::JsonSchema))]
pub struct RowRecord {
    /// Structure.
    pub structure: String,
    /// What differs from its defaults.
    pub settings: String,
    /// The row that the ratios of this scene are taken to: the reference of the run, or one in its
    /// place where that was not built or is wrong.
    pub is_reference: bool,
    /// Which rays it answers.
    #[serde(default)]
    pub answers: Answered,
    /// How it was asked.
    #[serde(default)]
    pub query: Query,
    /// What is said of it.
    pub verdict: Verdict,
    /// The defect it keeps on purpose.
    pub known_defect: Option<String>,
    /// Why it was not built, what its panic said, or which limit it is over.
    pub error: Option<String>,
    /// What was built.
    pub shape: Option<ShapeRecord>,
    /// Work of the counting pass.
    pub work: Option<WorkRecord>,
    /// Rays whose answers were compared.
    pub checked_rays: u64,
    /// Of those, rays answered wrongly.
    pub mismatches: u64,
    /// SHA-256 of all answers that were compared: id and bits of t of each hit, blocked or not of
    /// each shadow ray. None in records from before.
    #[serde(default)]
    pub answers_sha256: Option<String>,
    /// The first wrong answer, in words.
    pub example: Option<String>,
    /// Every how many-th ray of the scene was timed.
    pub stride: u64,
    /// Rays timed in a round.
    pub rays: u64,
    /// The same by kind.
    pub rays_by_kind: BTreeMap<String, u64>,
    /// Build time, seconds.
    pub build_s: Option<Estimate>,
    /// Trace time of all kinds, seconds.
    pub trace_s: Option<Estimate>,
    /// Millions of rays a second by kind, from the median time.
    pub mrays: BTreeMap<String, f64>,
    /// Trace time divided by the reference's in the same round, on the same rays.
    pub ratio: Option<Estimate>,
    /// The same for each kind of ray. Empty in records from before.
    #[serde(default)]
    pub ratio_by_kind: BTreeMap<String, Estimate>,
    /// Build time divided by the reference's in the same round.
    pub build_ratio: Option<Estimate>,
    /// The whole image through the renderer, seconds.
    pub render_s: Option<f64>,
    /// Every visit.
    pub samples: Vec<Sample>,
    /// Visits far from the others; they count like all others.
    #[serde(default)]
    pub outliers: Outliers,
    /// Bytes that a process of its own took more at the peak of the build than before it; measured
    /// by `rtbench scale` only.
    #[serde(default)]
    pub peak_build_bytes: Option<u64>,
}

/// Samples of a row beyond the fences of [`outliers`], none of them dropped.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "testing", derive(schemars::JsonSchema))]
pub struct Outliers {
    /// Builds that took too little, too much.
    pub build: [u64; 2],
    /// The same of all rays.
    pub trace: [u64; 2],
}

impl Outliers {
    /// Those among samples.
    pub fn of(samples: &[Sample]) -> Self {
        let count = |seconds: fn(&Sample) -> f64| {
            let seconds: Vec<f64> = samples.iter().map(seconds).collect();
            outliers(&seconds).map(|n| n as u64)
        };
        Self { build: count(|s| s.build_s), trace: count(Sample::total_trace_s) }
    }
}

impl RowRecord {
    /// Structure and settings.
    pub fn label(&self) -> String {
        label(&self.structure, &self.settings)
    }

    /// The same structure with the same settings, of another scene or run.
    pub fn is_same(&self, other: &Self) -> bool {
        self.structure == other.structure && self.settings == other.settings
    }

    /// Seconds from the primitives to the first whole image: the build and the image.
    pub fn first_image_s(&self) -> Option<f64> {
        Some(self.build_s?.median + self.render_s?)
    }
}

/// A row over all finished scenes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "testing", derive(schemars::JsonSchema))]
pub struct SummaryRow {
    /// Structure.
    pub structure: String,
    /// What differs from its defaults.
    pub settings: String,
    /// Scenes that its means are over: those with a ratio, all of them to one reference.
    pub scenes: u64,
    /// Scenes where it gave wrong answers.
    pub wrong_scenes: u64,
    /// Scenes where it was not built, or panicked.
    pub not_built_scenes: u64,
    /// Wrong answers in all scenes.
    pub mismatches: u64,
    /// Which rays it answers.
    #[serde(default)]
    pub answers: Answered,
    /// Geometric mean over those scenes of the trace ratio.
    pub ratio: Option<Estimate>,
    /// The same for each kind of ray. Empty in records from before.
    #[serde(default)]
    pub ratio_by_kind: BTreeMap<String, Estimate>,
    /// Of those scenes, the ones where it answered batches.
    #[serde(default)]
    pub batch_scenes: u64,
    /// Geometric mean over those scenes of the build ratio.
    pub build_ratio: Option<Estimate>,
    /// What is said of it: the worst of its scenes.
    pub verdict: Verdict,
}

impl RowRecord {
    /// Structure and settings, with a word where it answers batches: for texts and plots that have
    /// rows of both.
    pub fn label_with_query(&self) -> String {
        worded(self.label(), self.query == Query::Batch)
    }
}

impl SummaryRow {
    /// The same over all scenes.
    pub fn label_with_query(&self) -> String {
        worded(label(&self.structure, &self.settings), self.batch_scenes > 0)
    }
}

fn worded(label: String, answers_batches: bool) -> String {
    if answers_batches { format!("{label} (batch)") } else { label }
}

impl SceneRecord {
    /// Rays of all kinds, each once.
    pub fn distinct_rays(&self) -> u64 {
        distinct(&self.rays).map(|(_, n)| n).sum()
    }
}
