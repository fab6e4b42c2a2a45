//! A program outside, as a row of a scene: `rtbench rays check --into`.

use crate::record::{ForeignRecord, RowRecord, Verdict};
use statistics::estimate::Estimate;

/// Results that an external program reports.
#[derive(Debug, Clone, PartialEq)]
pub struct ExternalResult {
    pub name: String,
    /// SHA-256 of the file of its answers.
    pub hits_sha256: String,
    /// Seconds for all rays of that file.
    pub trace_s: f64,
    /// Seconds of the build.
    pub build_s: Option<f64>,
    /// Verdicts on its answers.
    pub answers: Vec<JudgedKind>,
}

/// Verdict on the answers to one kind of ray.
#[derive(Debug, Clone, PartialEq)]
pub struct JudgedKind {
    pub kind: String,
    pub compared: u64,
    /// Number of these answered wrongly.
    pub wrong: u64,
    /// Number of these that differ from the expected answer at an edge.
    pub edges: u64,
    /// The first wrong answer, in words.
    pub example: Option<String>,
}

impl ExternalResult {
    /// The row of a program whose answers were judged: times as it says, unless some are wrong.
    /// There are no samples, no ratio and no interval: it was not in the rounds of the run.
    pub fn row(self) -> RowRecord {
        let sum = |of: fn(&JudgedKind) -> u64| self.answers.iter().map(of).sum::<u64>();
        let mismatches = sum(|judged| judged.wrong);
        let verdict = if mismatches > 0 { Verdict::Wrong } else { Verdict::Ok };
        let is_timed = |_: &f64| verdict.is_timed();
        RowRecord {
            checked_rays: sum(|judged| judged.compared),
            mismatches,
            example: self.answers.iter().find_map(|judged| judged.example.clone()),
            rays: sum(|judged| judged.compared),
            rays_by_kind: self.answers.iter().map(|j| (j.kind.clone(), j.compared)).collect(),
            trace_s: Some(self.trace_s).filter(is_timed).map(Estimate::exactly),
            build_s: self.build_s.filter(is_timed).map(Estimate::exactly),
            foreign: Some(ForeignRecord {
                hits_sha256: self.hits_sha256.clone(),
                edge_mismatches: sum(|judged| judged.edges),
            }),
            ..RowRecord::unmeasured(self.name.clone(), String::new(), verdict)
        }
    }
}
