//! Bencher Metric Format: benchmark, measure, and of each a `value` with `lower_value` and
//! `upper_value` (<https://bencher.dev/docs/reference/bencher-metric-format/>). A benchmark is a
//! row of a scene; measures are the metrics of `rtbench` and rays per second by kind.

use std::collections::BTreeMap;

use serde::Serialize;

use crate::exports::measures::{Select, costs, rates};
use measurement::record::RunRecord;
use presentation::json;
use presentation::json::FormatError;

#[derive(Debug, Serialize)]
struct Metric {
    value: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    lower_value: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    upper_value: Option<f64>,
}

/// Times, ratios, counters and rays per second.
pub fn to_string(run: &RunRecord, select: Select<'_>) -> Result<String, FormatError> {
    let mut benchmarks: BTreeMap<String, BTreeMap<String, Metric>> = BTreeMap::new();
    for m in costs(run, select).into_iter().chain(rates(run, select)) {
        let [lower_value, upper_value] = [m.interval.map(|i| i[0]), m.interval.map(|i| i[1])];
        let metric = Metric { value: m.value, lower_value, upper_value };
        benchmarks.entry(m.row).or_default().insert(m.name, metric);
    }
    json::written(&benchmarks)
}
