//! Results of other commands in the folder.

use serde::Deserialize;
use statistics::estimate::Estimate;

/// A figure as `rtbench reproduce havran1999 --export-csv` writes it.
#[derive(Debug, Clone, Deserialize)]
pub struct ReproducedFigure {
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
