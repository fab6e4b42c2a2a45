//! Settings of a comparison.

use measurement::record::RunRecord;
use measurement::record::metrics::Metric;
use regex_lite::Regex;
use statistics::estimate::Estimate;

use crate::comparison::entry::{ComparisonOutcome, exceeds};

/// Records to compare, and the parts to show.
#[derive(Debug)]
pub struct ComparisonSettings {
    pub metrics: Vec<&'static Metric>,
    /// Exact metrics that are equal are shown, not only counted.
    pub shows_equal: bool,
    /// Finds what is compared.
    pub filter: Option<Regex>,
    /// The share by which a ratio may differ from 1 and be called no difference.
    pub margin: f64,
    /// The share of change that is shown from.
    pub threshold: Option<f64>,
    /// Compare records that are not comparable.
    pub is_forced: bool,
    /// Rows in the order of the record, or the largest change first.
    pub by_change: bool,
}

impl ComparisonSettings {
    /// Returns whether the filter, if there is one, finds a metric of a row.
    pub fn finds(&self, scene: &str, label: &str, metric: &str) -> bool {
        let found = |filter: &Regex| filter.is_match(&format!("{scene}/{label}/{metric}"));
        self.filter.as_ref().is_none_or(found)
    }

    /// Returns whether what came of a comparison is shown.
    pub fn shows(&self, ratio: Option<Estimate>, outcome: ComparisonOutcome) -> bool {
        (outcome != ComparisonOutcome::Equal || self.shows_equal)
            && self.threshold.is_none_or(|share| exceeds(ratio, outcome, share))
    }
}

/// A run with the name it is given in tables.
#[derive(Debug, Clone, Copy)]
pub struct NamedRun<'r> {
    /// `A`, `B`, ...
    pub letter: &'r str,
    /// Path it was read from.
    pub path: &'r str,
    pub run: &'r RunRecord,
}
