//! What can be compared between rows of runs: one registry line a metric.
//!
//! Exact metrics are the same on every machine and in every run of the same program; measured ones
//! have a sample a round.

use crate::comparison::differences::Concerns;
use crate::plan::PlanError;
use crate::record::{RowRecord, SceneRecord, WorkRecord};
use crate::scene_run::{build_ratios, trace_ratios};
use crate::suggest::hint;

/// A metric of a row; smaller is better, of all of them.
#[derive(Debug, Clone, Copy)]
pub struct Metric {
    /// As in CSV files and on the command line.
    pub name: &'static str,
    /// Unit of its values; empty for counts and ratios.
    pub unit: &'static str,
    /// What it is, for help and glossaries.
    pub summary: &'static str,
    /// How it is read off a row.
    pub reading: Reading,
}

/// How a metric is read off a row.
#[derive(Debug, Clone, Copy)]
pub enum Reading {
    /// One value that no machine changes; none where the row has none.
    Exact(fn(&RowRecord) -> Option<f64>),
    /// A sample a round, of a row of a scene.
    Measured(fn(&SceneRecord, &RowRecord) -> Vec<f64>),
}

impl Metric {
    /// The same in every run of the same program.
    pub fn is_exact(&self) -> bool {
        matches!(self.reading, Reading::Exact(_))
    }

    /// It is taken to the reference of the same run.
    pub fn is_to_reference(&self) -> bool {
        self.name.ends_with("ratio")
    }

    /// Whether a difference of that kind between two runs keeps it from being compared.
    pub fn is_concerned(&self, by: Concerns) -> bool {
        match by {
            Concerns::Everything => true,
            Concerns::Seconds => self.unit == "s",
            Concerns::Ratios => self.is_to_reference(),
            Concerns::Nothing => false,
        }
    }

    /// How many rays its values are over; none where they are not over rays. A slow row is asked a
    /// sample, the size of which is found by timing.
    pub fn rays(&self, row: &RowRecord) -> Option<u64> {
        match self.name {
            "trace" | "ratio" => Some(row.rays),
            _ if OF_WORK.contains(&self.name) => Some(row.work.as_ref()?.rays),
            _ => None,
        }
    }

    /// Its values in a row of a scene: none, one, or one a round.
    pub fn values(&self, scene: &SceneRecord, row: &RowRecord) -> Vec<f64> {
        match self.reading {
            Reading::Exact(read) => read(row).into_iter().collect(),
            Reading::Measured(read) => read(scene, row),
        }
    }
}

/// Metrics of the rays that were counted.
const OF_WORK: [&str; 5] = ["n_it", "n_ts", "n_ets", "n_eets", "saved"];

/// The metric of that name.
///
/// # Errors
/// [`PlanError::UnknownName`] with all names.
pub fn named(name: &str) -> Result<&'static Metric, PlanError> {
    let names = || METRICS.iter().map(|m| m.name);
    METRICS.iter().find(|m| m.name == name).ok_or_else(|| PlanError::UnknownName {
        what: "metric",
        name: name.into(),
        hint: hint(name, names()),
        valid: names().collect::<Vec<_>>().join(", "),
    })
}

/// All metrics, exact ones first.
pub static METRICS: &[Metric] = &[
    exact("n_in", "", "inner cells", |row| Some(row.shape.as_ref()?.n_in as f64)),
    exact("n_v", "", "elementary cells", |row| Some(row.shape.as_ref()?.n_v as f64)),
    exact("n_ev", "", "empty elementary cells", |row| Some(row.shape.as_ref()?.n_ev as f64)),
    exact("n_oiv", "", "references in cells", |row| Some(row.shape.as_ref()?.n_oiv as f64)),
    exact("memory", "bytes", "bytes of the structure", |row| {
        Some(row.shape.as_ref()?.memory_bytes as f64)
    }),
    exact("n_it", "", "intersection tests per ray", |row| per_ray(row, |w| w.intersection_tests)),
    exact("n_ts", "", "traversal steps per ray", |row| per_ray(row, |w| w.traversal_steps)),
    exact("n_ets", "", "elementary steps per ray", |row| per_ray(row, |w| w.elementary_steps)),
    exact("n_eets", "", "empty elementary steps per ray", |row| {
        per_ray(row, |w| w.empty_elementary_steps)
    }),
    exact("saved", "", "tests per ray that a mailbox spared", |row| {
        per_ray(row, |w| w.tests_saved)
    }),
    measured("build", "s", "build time", |_, row| row.samples.iter().map(|s| s.build_s).collect()),
    measured("trace", "s", "trace time of all rays", |_, row| {
        row.samples.iter().map(|s| s.total_trace_s()).collect()
    }),
    measured(
        "build-ratio",
        "",
        "build time over the reference's of the same round",
        |scene, row| {
            let reference = scene.rows.iter().filter(|r| r.is_reference).flat_map(|r| &r.samples);
            build_ratios(row, &reference.map(|s| (s.round, s.build_s)).collect::<Vec<_>>())
        },
    ),
    measured("ratio", "", "trace time over the reference's of the same round", |_, row| {
        trace_ratios(row)
    }),
];

const fn exact(
    name: &'static str,
    unit: &'static str,
    summary: &'static str,
    read: fn(&RowRecord) -> Option<f64>,
) -> Metric {
    Metric { name, unit, summary, reading: Reading::Exact(read) }
}

const fn measured(
    name: &'static str,
    unit: &'static str,
    summary: &'static str,
    read: fn(&SceneRecord, &RowRecord) -> Vec<f64>,
) -> Metric {
    Metric { name, unit, summary, reading: Reading::Measured(read) }
}

fn per_ray(row: &RowRecord, of: fn(&WorkRecord) -> u64) -> Option<f64> {
    let work = row.work.as_ref()?;
    Some(of(work) as f64 / work.rays.max(1) as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn metrics_over_rays_are_there() {
        assert!(OF_WORK.iter().chain(&["trace", "ratio"]).all(|name| named(name).is_ok()));
        let error = named("n_its").unwrap_err().to_string();
        assert!(
            error.contains("unknown metric 'n_its' (did you mean 'n_it'?); valid: n_in, "),
            "{error}"
        );
    }
}
