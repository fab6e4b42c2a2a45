//! The files that `rtbench run` writes: one line a format; and a run as a flat list of named numbers,
//! for services that keep time series.
//!
//! Of that list rows are left out whose times may not be shown (wrong, not built, panicked), counters
//! and all; `run` ends with exit code 4 or 1 for them. Ratios that are to another row than the run's
//! reference are left out, too: they would be another series under the same name.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde::Serialize;

use crate::args::ExportArgs;
use crate::context::Context;
use crate::outputs::{OutputError, Outputs};
use measurement::journal;
use measurement::journal::lines::Manifest;
use measurement::plan::Plan;
use measurement::rays::order::batch_name;
use measurement::record::metrics::{METRICS, Metric, Reading, series};
use measurement::record::{RowRecord, RunRecord, SceneRecord, file, reference};
use measurement::system::files::CreatedFiles;
use presentation::json::{self, FormatError};
use studies::run::output;

/// The text of what is finished so far.
type Format = fn(&RunRecord) -> Result<String, FormatError>;

/// The files in the folder of `-o`, the record first: it says of which run the files beside it are,
/// also when the program is killed between the first two.
static IN_FOLDER: [(&str, Format); 3] = [
    (file::NAME, json::written),
    ("results.csv", output::to_csv),
    ("results.md", |run| Ok(output::to_markdown(run))),
];

/// A file of a service that keeps time series: its path, its numbers, and their text.
type SeriesFile<'a> =
    (&'a Option<PathBuf>, fn(&RunRecord) -> Vec<Measure>, fn(Vec<Measure>) -> SeriesText);
pub type SeriesText = Result<String, FormatError>;

fn series_files(args: &ExportArgs) -> [SeriesFile<'_>; 3] {
    [
        (&args.export_github_smaller, costs, github),
        (&args.export_github_bigger, rates, github),
        (&args.export_bencher, measures, bencher),
    ]
}

pub fn named(args: &ExportArgs) -> Vec<PathBuf> {
    series_files(args).into_iter().filter_map(|(path, ..)| path.clone()).collect()
}

/// Refuses a folder of `-o` that holds other results, unless they may be replaced.
pub fn refuse_occupied(
    context: &Context<'_>,
    args: &ExportArgs,
    manifest: Option<&Manifest>,
) -> Result<(), OutputError> {
    let names = IN_FOLDER.map(|(name, _)| name);
    args.output.iter().try_for_each(|folder| context.refuse_occupied(folder, &names, manifest))
}

/// Files that are written to a folder of `-o`, including the journal of a run.
pub fn files_in(folder: &Path) -> Vec<PathBuf> {
    let names = IN_FOLDER.iter().map(|(name, _)| *name);
    names.chain([journal::NAME]).map(|name| folder.join(name)).collect()
}

/// Refuses a selection that finds none of these series.
pub fn refuse_unselected(
    args: &ExportArgs,
    series: impl FnOnce() -> Vec<String>,
) -> Result<(), OutputError> {
    let Some(select) = &args.export_select else { return Ok(()) };
    let series = series();
    if series.iter().any(|series| select.is_match(series)) {
        return Ok(());
    }
    let example = series.into_iter().next().unwrap_or_default();
    Err(OutputError::NothingSelected(select.as_str().to_owned(), example))
}

/// Creates the files that the command line of a run names.
pub fn of_run(args: &ExportArgs) -> Result<Outputs<'static>, OutputError> {
    let mut created = CreatedFiles::default();
    args.output.iter().try_for_each(|folder| created.folder(folder))?;
    let mut outputs = Outputs::new(args.output.clone(), created);
    for (name, format) in IN_FOLDER {
        outputs.add_in_folder(name, format)?;
    }
    for (path, measures, format) in series_files(args) {
        let select = args.export_select.clone();
        outputs.add(path.clone(), move |run| {
            let mut measures = measures(run);
            measures.retain(|m| select.as_ref().is_none_or(|s| s.is_match(&m.series())));
            format(measures)
        })?;
    }
    Ok(outputs)
}

/// A number of a row of a scene.
pub struct Measure {
    /// Scene and row: `teapot: uniform-grid density=1`.
    row: String,
    /// As in [`METRICS`]; of rates `mrays-primary` and so on.
    name: String,
    unit: &'static str,
    /// The value; of what was measured, the median.
    value: f64,
    /// The ends of the 95% interval, of what was measured.
    interval: Option<[f64; 2]>,
}

impl Measure {
    /// As charts call it, and as `--export-select` finds it.
    fn series(&self) -> String {
        format!("{} / {}", self.row, self.name)
    }
}

/// Times, ratios, counters and rays per second.
pub fn measures(run: &RunRecord) -> Vec<Measure> {
    costs(run).into_iter().chain(rates(run)).collect()
}

/// The series of a run.
pub fn series_in(run: &RunRecord) -> Vec<String> {
    measures(run).iter().map(Measure::series).collect()
}

/// Metrics that are costs; those of a kind of rays are rates instead.
fn cost_metrics() -> impl Iterator<Item = &'static Metric> {
    METRICS.iter().filter(|m| m.is_cost && !matches!(m.reading, Reading::RatioOf(_)))
}

fn timed_rows(run: &RunRecord) -> impl Iterator<Item = (&SceneRecord, &RowRecord)> {
    let rows = run.scenes.iter().flat_map(|scene| scene.rows.iter().map(move |row| (scene, row)));
    rows.filter(|(_, row)| row.verdict.is_timed())
}

/// Times, ratios and counters: the metrics of every timed row that are costs. Smaller is better.
fn costs(run: &RunRecord) -> Vec<Measure> {
    let mut measures = Vec::new();
    for (scene, row) in timed_rows(run) {
        let has_ratios = reference::is_over(scene, &run.settings.reference);
        for metric in cost_metrics().filter(|m| has_ratios || !m.is_to_reference()) {
            let found = metric.values(scene, row).estimate(run.settings.seed);
            let is_exact = metric.is_exact();
            measures.extend(found.map(|found| Measure {
                row: name_of(&scene.name, &row.label()),
                name: metric.name.to_owned(),
                unit: match metric.unit {
                    "" if is_exact => "count",
                    "" => "ratio",
                    unit => unit,
                },
                value: found.median,
                interval: (!is_exact).then_some([found.low, found.high]),
            }));
        }
    }
    measures
}

/// Millions of rays per second by kind, of every timed row. Bigger is better.
fn rates(run: &RunRecord) -> Vec<Measure> {
    let mut measures = Vec::new();
    for (scene, row) in timed_rows(run) {
        for (kind, &rays) in &row.rays_by_kind {
            let seconds = series(row, |s| s.trace_s.get(kind).copied());
            let found = seconds.estimate(run.settings.seed).filter(|seconds| seconds.low > 0.0);
            let rate = |seconds: f64| rays as f64 / seconds / 1e6;
            measures.extend(found.map(|found| Measure {
                row: name_of(&scene.name, &row.label()),
                name: rate_name(kind),
                unit: "Mrays/s",
                value: rate(found.median),
                interval: Some([rate(found.high), rate(found.low)]),
            }));
        }
    }
    measures
}

/// The series that a plan will have, but for rows that are wrong or not built.
pub fn series_of(plan: &Plan<'_>) -> Vec<String> {
    let rates = plan.kinds.iter().flat_map(|kind| {
        let orders = plan.orders.orders().iter();
        orders.map(|order| rate_name(&batch_name(kind.name(), *order)))
    });
    let names: Vec<String> =
        cost_metrics().map(|metric| metric.name.to_owned()).chain(rates).collect();
    let rows = plan
        .scenes
        .iter()
        .flat_map(|scene| plan.rows.iter().map(|row| name_of(scene.name(), &row.label())));
    rows.flat_map(|row| names.iter().map(move |name| format!("{row} / {name}")).collect::<Vec<_>>())
        .collect()
}

fn name_of(scene: &str, row: &str) -> String {
    format!("{scene}: {row}")
}

fn rate_name(kind: &str) -> String {
    format!("mrays-{kind}")
}

/// A number in Bencher Metric Format.
#[derive(Debug, Serialize)]
struct BencherMetric {
    value: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    lower_value: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    upper_value: Option<f64>,
}

pub fn bencher(measures: Vec<Measure>) -> SeriesText {
    let mut benchmarks: BTreeMap<String, BTreeMap<String, BencherMetric>> = BTreeMap::new();
    for Measure { row, name, value, interval, .. } in measures {
        let (lower_value, upper_value) = interval.map(|[low, high]| (low, high)).unzip();
        let metric = BencherMetric { value, lower_value, upper_value };
        benchmarks.entry(row).or_default().insert(name, metric);
    }
    json::written(&benchmarks)
}

/// A number of github-action-benchmark over time.
#[derive(Debug, Serialize)]
struct Entry {
    name: String,
    unit: &'static str,
    value: f64,
    /// Shown behind the value as it is.
    #[serde(skip_serializing_if = "Option::is_none")]
    range: Option<String>,
}

pub fn github(measures: Vec<Measure>) -> SeriesText {
    let entry = |m: Measure| Entry {
        name: m.series(),
        unit: m.unit,
        value: m.value,
        range: m.interval.map(|[low, high]| format!("{low:.4e} to {high:.4e}")),
    };
    json::written(&measures.into_iter().map(entry).collect::<Vec<_>>())
}
