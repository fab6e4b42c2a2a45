//! For the GitHub Action github-action-benchmark, tools `customSmallerIsBetter` and
//! `customBiggerIsBetter`: a JSON array of `name`, `unit`, `value` and `range`
//! (<https://github.com/benchmark-action/github-action-benchmark>). The action takes one file for
//! each direction.

use serde::Serialize;

use crate::exports::measures::{Measure, Select, costs, rates};
use measurement::record::RunRecord;
use presentation::json;
use presentation::json::FormatError;

/// One number over time.
#[derive(Debug, Serialize)]
struct Entry {
    name: String,
    unit: &'static str,
    value: f64,
    /// Shown behind the value as it is.
    #[serde(skip_serializing_if = "Option::is_none")]
    range: Option<String>,
}

/// Times, ratios and counters.
pub fn smaller(run: &RunRecord, select: Select<'_>) -> Result<String, FormatError> {
    json::written(&entries(costs(run, select)))
}

/// Rays per second.
pub fn bigger(run: &RunRecord, select: Select<'_>) -> Result<String, FormatError> {
    json::written(&entries(rates(run, select)))
}

fn entries(measures: Vec<Measure>) -> Vec<Entry> {
    let entry = |m: Measure| Entry {
        name: m.series(),
        unit: m.unit,
        value: m.value,
        range: m.interval.map(|[low, high]| format!("{low:.4e} to {high:.4e}")),
    };
    measures.into_iter().map(entry).collect()
}
