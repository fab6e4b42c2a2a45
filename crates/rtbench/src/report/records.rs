//! What other commands left in the folder.

use serde::Deserialize;
use statistics::estimate::Estimate;
use studies::accuracy::record::Standing;

/// A figure as `rtbench reproduce havran1999 --export-csv` writes it.
#[derive(Debug, Clone, Deserialize)]
pub struct Reproduced {
    pub(super) scene: String,
    pub(super) structure: String,
    pub(super) params: String,
    pub(super) counter: String,
    pub(super) published: String,
    pub(super) ours: f64,
    pub(super) verdict: String,
}

/// A row as `rtbench reproduce zachmann2007 --export-csv` writes it.
#[derive(Debug, Clone, Deserialize)]
pub struct LectureRow {
    pub(super) scene: String,
    pub(super) lecture: String,
    pub(super) ours: String,
    pub(super) verdict: String,
    pub(super) build_then: Option<f64>,
    pub(super) build_now: Option<f64>,
    pub(super) build_low: Option<f64>,
    pub(super) build_high: Option<f64>,
    pub(super) run_then: Option<f64>,
    pub(super) run_now: Option<f64>,
    pub(super) run_low: Option<f64>,
    pub(super) run_high: Option<f64>,
}

impl LectureRow {
    pub(super) fn build(&self) -> Option<Estimate> {
        let (median, low, high) = (self.build_now?, self.build_low?, self.build_high?);
        Some(Estimate { median, low, high })
    }

    pub(super) fn run(&self) -> Option<Estimate> {
        let (median, low, high) = (self.run_now?, self.run_low?, self.run_high?);
        Some(Estimate { median, low, high })
    }
}

/// A comparison as `rtbench compare-tracers -o` writes it; candidate queries are left out.
#[derive(Debug, Clone, Deserialize)]
pub struct TracersRecord {
    /// The command line, program first.
    pub command_line: Vec<String>,
    pub(super) scene: String,
    pub(super) resolution: [u32; 2],
    pub(super) threads: usize,
    pub(super) seed: u64,
    pub(super) reference: Reference,
    pub(super) images: Vec<Image>,
}

#[derive(Debug, Clone, Deserialize)]
pub(super) struct Reference {
    pub(super) own_error: f64,
    pub(super) samples: u32,
}

#[derive(Debug, Clone, Deserialize)]
pub(super) struct Image {
    pub(super) row: RecordedRow,
    pub(super) outcome: Outcome,
}

#[derive(Debug, Clone, Deserialize)]
pub(super) struct RecordedRow {
    pub(super) tracer: String,
    pub(super) settings: String,
    pub(super) samples: Option<u32>,
}

impl RecordedRow {
    pub(super) fn label(&self) -> String {
        let samples = self
            .samples
            .map(|n| format!(" {n} sample{}", if n == 1 { "" } else { "s" }))
            .unwrap_or_default();
        format!("{} {}", self.tracer, self.settings).trim_end().to_owned() + &samples
    }
}

#[derive(Debug, Clone, Deserialize)]
#[serde(untagged)]
pub(super) enum Outcome {
    Refused { refused: String },
    Made { seconds: Vec<f64>, rmse: f64, below_reference: bool, standing: Standing },
}
