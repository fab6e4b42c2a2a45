//! The results of a scene, and what they say of the questions that a run is made for: which row is
//! the fastest, which the smallest.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::rays::order::{distinct, kind_of};
use crate::record::query::Query;
use crate::record::row::{AnsweredRays, RowRecord, Verdict, label, with_query};
use statistics::estimate::Estimate;

#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "testing", derive(schemars::JsonSchema))]
pub struct SceneRecord {
    /// Name of the scene, as it was asked for.
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
    /// Whether all of them are triangles at rest: blocks of triangles serve such scenes alone. None
    /// in records from before, and of scenes that were not loaded.
    #[serde(default)]
    pub only_triangles: Option<bool>,
    /// Where the scene's origin is in the coordinates of its file, if it was moved there.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub origin: Option<[f64; 3]>,
    /// What the loader noticed.
    pub warnings: Vec<String>,
    /// Rays of each kind; those in shuffled order by `KIND-shuffled`, here and in all rows.
    pub rays: BTreeMap<String, u64>,
    /// How answers were judged.
    pub oracle: OracleRecord,
    /// One for each structure and setting.
    pub rows: Vec<RowRecord>,
    /// Programs outside, merged in later: in no ratio, no mean and no comparison.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub foreign: Vec<RowRecord>,
    /// Largest resident set while the scene was measured, bytes.
    pub peak_rss_bytes: Option<u64>,
    /// Which rows are the fastest and the smallest. Empty in records from before.
    #[serde(default)]
    pub conclusions: Vec<Conclusion>,
    /// Which row takes the least time, build included, for how many rays; empty where none may
    /// lead.
    #[serde(default)]
    pub least_time: Vec<LeastTime>,
}

/// How the answers of a scene were judged.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "testing", derive(schemars::JsonSchema))]
pub struct OracleRecord {
    /// The row that was asked first, with which all others are compared; none if f64 brute force
    /// refuted every one on the sample.
    pub reference: Option<String>,
    /// Structures that were not asked first, with what brute force refuted or why they were not
    /// built.
    pub refused: Vec<String>,
    /// Rays of the sample that was compared with f64 brute force.
    pub checked: u64,
    /// Of those, borderline rays: rounding alone decides their answer (see `oracle.rs`).
    pub borderline: u64,
    /// The same for each kind of ray: checked, borderline.
    pub by_kind: BTreeMap<String, [u64; 2]>,
}

impl SceneRecord {
    /// Rays of all kinds, each once.
    pub fn distinct_rays(&self) -> u64 {
        distinct(&self.rays).map(|(_, n)| n).sum()
    }

    /// Whether a row may be called the best of anything: all its answers were compared, each is
    /// right, and its settings keep no defect.
    pub fn may_lead(&self, row: &RowRecord) -> bool {
        let is_answered = |kind: &str| match row.answers {
            AnsweredRays::AllRays => true,
            AnsweredRays::ShadowRays => kind_of(kind) == "shadow",
        };
        let answered = distinct(&self.rays).filter(|(kind, _)| is_answered(kind));
        row.verdict == Verdict::Ok
            && row.mismatches == 0
            && row.known_defect.is_none()
            && row.rays > 0
            && row.checked_rays >= answered.map(|(_, n)| n).sum()
    }
}

/// A row over all finished scenes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "testing", derive(schemars::JsonSchema))]
pub struct SummaryRow {
    /// Name of the structure, without its settings.
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
    pub answers: AnsweredRays,
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

impl SummaryRow {
    /// Whether it may be called the best of anything in every scene that it is in.
    pub fn may_lead(&self, scenes: &[SceneRecord]) -> bool {
        let is_same =
            |row: &&RowRecord| row.structure == self.structure && row.settings == self.settings;
        scenes.iter().all(|scene| scene.rows.iter().filter(is_same).all(|row| scene.may_lead(row)))
    }

    /// Structure and settings, with a word where it answers batches in any of its scenes.
    pub fn label_with_query(&self) -> String {
        with_query(label(&self.structure, &self.settings), self.batch_scenes > 0)
    }
}

/// What a run is asked.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "testing", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Question {
    /// Least time for the build, one million primary rays and their shadow rays, seconds.
    FirstImage,
    /// Least time for a ray of a kind and order, seconds.
    Trace(String),
    /// Fewest bytes of what was built; no interval, as nothing of it is measured.
    Memory,
}

/// The row that answers a question best, and how it stands against the others.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "testing", derive(schemars::JsonSchema))]
pub struct Conclusion {
    pub question: Question,
    /// Of which rows: those that answer ray by ray, or those that answer batches as well.
    pub query: Query,
    /// The row with the least median.
    pub row: String,
    /// Its figure in the unit of the question; over several scenes the geometric mean.
    pub figure: Estimate,
    /// Rows that are not significantly different from it.
    pub not_different: Vec<String>,
    /// The nearest row that is significantly different; none where there is none.
    pub next: Option<NextRow>,
    /// Rows that do not lead, since answers may be wrong by a known defect, and are closer than the
    /// next row, as fast or faster; the fastest first.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub defective: Vec<Defective>,
}

/// A row with a known defect beside the best one without.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "testing", derive(schemars::JsonSchema))]
pub struct Defective {
    /// Structure and settings.
    pub row: String,
    /// How many times as much as the best row it takes, paired by round.
    pub times: Estimate,
    /// Answers that were wrong.
    pub wrong: u64,
    /// Answers that were compared.
    pub rays: u64,
}

/// The nearest row that is significantly different from the best one.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "testing", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "testing", schemars(rename = "Next"))]
pub struct NextRow {
    /// Structure and settings.
    pub row: String,
    /// How many times as much it takes, paired by round.
    pub times: Estimate,
}

/// The row of least time, build included, from some number of rays on.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "testing", derive(schemars::JsonSchema))]
pub struct LeastTime {
    /// Structure and settings.
    pub row: String,
    /// Rays from which on it takes the least time; the first row does from 0 on.
    pub from_rays: f64,
    /// The lower end of the 95% interval of that number.
    pub low: f64,
    /// Its upper end; none where some resamples never reach it.
    pub high: Option<f64>,
}
