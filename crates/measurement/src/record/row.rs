//! The results of a row in a scene: what was built, the work it does for rays, and its times.

use std::collections::BTreeMap;

use accel_core::query::counters::WorkCounters;
use accel_core::query::tracer::Foreign;
use serde::{Deserialize, Serialize};

use crate::record::query::Query;
use statistics::estimate::{Estimate, outliers};
use statistics::series::TwoLevels;

/// Which rays a row answers.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "testing", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "testing", schemars(rename = "Answered"))]
pub enum AnsweredRays {
    /// Rays of every kind: a structure.
    #[default]
    #[serde(rename = "all rays")]
    AllRays,
    /// Shadow rays only: an occluder. Its times and ratios are over these.
    #[serde(rename = "shadow rays")]
    ShadowRays,
}

impl AnsweredRays {
    pub fn name(self) -> &'static str {
        match self {
            Self::AllRays => "all rays",
            Self::ShadowRays => "shadow rays",
        }
    }
}

/// One visit of a row.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "testing", derive(schemars::JsonSchema))]
pub struct Sample {
    /// The process that it was made in, from 0: that of the run, and those that it started
    /// (`--processes`).
    #[serde(default)]
    pub process: u32,
    /// Round, from 0; those of the next process go on from the last one's.
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
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "testing", derive(schemars::JsonSchema))]
pub struct RowRecord {
    /// Name of the structure, without its settings.
    pub structure: String,
    /// What differs from its defaults.
    pub settings: String,
    /// The row that the ratios of this scene are taken to: the reference of the run, or one in its
    /// place where that was not built or is wrong.
    pub is_reference: bool,
    /// Which rays it answers.
    #[serde(default)]
    pub answers: AnsweredRays,
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
    #[serde(rename = "shape")]
    pub stats: Option<StatsRecord>,
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
    /// Stride of the rays that were timed: every k-th of the scene.
    pub stride: u64,
    /// Rays timed in a round.
    pub rays: u64,
    /// The same by kind.
    pub rays_by_kind: BTreeMap<String, u64>,
    /// Build time, seconds.
    pub build_s: Option<Estimate>,
    /// Trace time of all kinds, seconds.
    pub trace_s: Option<Estimate>,
    /// Millions of rays per second by kind, from the median time.
    pub mrays: BTreeMap<String, f64>,
    /// Trace time divided by the reference's in the same round, on the same rays.
    pub ratio: Option<Estimate>,
    /// The same for each kind of ray. Empty in records from before.
    #[serde(default)]
    pub ratio_by_kind: BTreeMap<String, Estimate>,
    /// The levels of the ratio where processes disagree about it more than their rounds do; of the
    /// reference, those of its trace time in seconds.
    #[serde(default)]
    pub levels: Option<TwoLevels>,
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
    /// by `rtbench sweep --sizes` only.
    #[serde(default)]
    pub peak_build_bytes: Option<u64>,
    /// The plugin that it is of; none for what is of this program.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub plugin: Option<PluginRecord>,
    /// What is known of a program that nobody here timed; none for rows of a run.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub foreign: Option<ForeignRecord>,
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
    pub fn of(samples: &[Sample]) -> Self {
        let count = |seconds: fn(&Sample) -> f64| {
            let seconds: Vec<f64> = samples.iter().map(seconds).collect();
            outliers(&seconds).map(|n| n as u64)
        };
        Self { build: count(|s| s.build_s), trace: count(Sample::total_trace_s) }
    }
}

impl RowRecord {
    pub fn unmeasured(structure: String, settings: String, verdict: Verdict) -> Self {
        Self { structure, settings, verdict, stride: 1, ..Self::default() }
    }

    /// Rays that a triangle test of another's answered otherwise than expected where rounding
    /// decides; none where answers are compared bit by bit.
    pub fn edge_mismatches(&self) -> Option<u64> {
        let of_plugin = self.plugin.as_ref().filter(|p| p.own_test).map(|p| p.edge_mismatches);
        of_plugin.or(self.foreign.as_ref().map(|foreign| foreign.edge_mismatches))
    }

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

    /// Structure and settings, with a word where it answers batches: for texts and plots that have
    /// rows of both.
    pub fn label_with_query(&self) -> String {
        with_query(self.label(), self.query == Query::Batch)
    }
}

/// Structure and settings as printed.
pub fn label(structure: &str, settings: &str) -> String {
    format!("{structure} {settings}").trim_end().to_owned()
}

/// The same with a word where it answers batches.
pub fn with_query(label: String, answers_batches: bool) -> String {
    if answers_batches { format!("{label} (batch)") } else { label }
}

/// What is said of a row.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "testing", derive(schemars::JsonSchema))]
pub enum Verdict {
    /// Every answer agrees.
    #[default]
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
    /// It answered in a separate process; else in that of the run.
    pub own_process: bool,
    /// Its own triangle test decided; else that of this program, and answers are compared bit by
    /// bit.
    pub own_test: bool,
    /// Seconds of a call that asks for nothing, to its process and back. Part of no time.
    pub empty_call_s: f64,
    /// With one thread, the part of its time that threads other than the one that asked had, while
    /// its answers were checked. It counts.
    #[serde(default)]
    pub other_threads: f64,
    /// Rays that were answered otherwise than expected where rounding decides, of the checked ones.
    pub edge_mismatches: u64,
    /// Its own remark on how it answers.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub note: Option<String>,
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
            note: foreign.note(),
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

/// What was built, in the symbols of Havran and Sixta (1999).
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "testing", derive(schemars::JsonSchema))]
pub struct StatsRecord {
    /// N_IN: hierarchical cells.
    pub n_in: u64,
    /// N_V: elementary cells.
    pub n_v: u64,
    /// N_EV: empty elementary cells.
    pub n_ev: u64,
    /// N_OIV: references in elementary cells.
    pub n_oiv: u64,
    /// Voxels per axis.
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
    /// Of so many rays.
    pub fn of(rays: usize, work: &WorkCounters) -> Self {
        Self {
            rays: rays as u64,
            intersection_tests: work.intersection_tests,
            traversal_steps: work.traversal_steps,
            elementary_steps: work.elementary_steps,
            empty_elementary_steps: work.empty_elementary_steps,
            tests_saved: work.tests_saved,
        }
    }

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
