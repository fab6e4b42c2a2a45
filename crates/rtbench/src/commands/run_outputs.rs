//! The files that `rtbench run` writes: one line a format; and a run as a flat list of named numbers,
//! for services that keep time series.
//!
//! Of that list rows are left out whose times may not be shown (wrong, not built, panicked), counters
//! and all; `run` ends with exit code 4 or 1 for them. Ratios that are to another row than the run's
//! reference are left out, too: they would be another series under the same name.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use regex_lite::Regex;
use serde::Serialize;

use crate::args::ExportArgs;
use crate::context::Context;
use crate::outputs::{OutputError, Outputs, PlannedOutput};
use measurement::journal;
use measurement::journal::lines::Manifest;
use measurement::plan::Plan;
use measurement::rays::order::batch_name;
use measurement::record::metrics::{METRICS, Reading, series};
use measurement::record::{RowRecord, RunRecord, file, reference};
use measurement::system::files::CreatedFiles;
use presentation::json::{self, FormatError};
use studies::run::output;

/// The text of what is finished so far.
type Format = fn(&RunRecord) -> Result<String, FormatError>;
/// The same of the series that are selected.
type SeriesFormat = fn(&RunRecord, Select<'_>) -> Result<String, FormatError>;

/// The files in the folder of `-o`, the record first: it says of which run the files beside it are,
/// also when the program is killed between the first two.
static IN_FOLDER: [(&str, Format); 3] = [
    (file::NAME, json::written),
    ("results.csv", output::to_csv),
    ("results.md", |run| Ok(output::to_markdown(run))),
];

/// The files of services that keep time series.
fn series_files(args: &ExportArgs) -> [(&Option<PathBuf>, SeriesFormat); 3] {
    [
        (&args.export_github_smaller, smaller),
        (&args.export_github_bigger, bigger),
        (&args.export_bencher, bencher),
    ]
}

pub fn named(args: &ExportArgs) -> Vec<PathBuf> {
    series_files(args).into_iter().filter_map(|(path, _)| path.clone()).collect()
}

/// Refuses a folder of `-o` that holds other results, unless they may be replaced.
pub fn refuse_occupied(
    context: &Context<'_>,
    args: &ExportArgs,
    manifest: Option<&Manifest>,
) -> Result<(), OutputError> {
    let Some(folder) = &args.output else { return Ok(()) };
    let names = IN_FOLDER.map(|(name, _)| name);
    let (command_line, overwrite) = (&*context.command_line, context.overwrite);
    PlannedOutput { names: &names, command_line, manifest, overwrite }.check(folder)
}

/// Files that are written to a folder of `-o`, including the journal of a run.
pub fn files_in(folder: &Path) -> Vec<PathBuf> {
    let names = IN_FOLDER.iter().map(|(name, _)| *name);
    names.chain([journal::NAME]).map(|name| folder.join(name)).collect()
}

/// Refuses a selection of series that finds none of those that a plan will have.
pub fn refuse_unselected(args: &ExportArgs, plan: &Plan<'_>) -> Result<(), OutputError> {
    let Some(select) = &args.export_select else { return Ok(()) };
    let all = series_of(plan);
    if all.iter().any(|series| select.is_match(series)) {
        Ok(())
    } else {
        let example = all.first().cloned().unwrap_or_default();
        Err(OutputError::NothingSelected(select.as_str().to_owned(), example))
    }
}

/// Creates the files that the command line of a run names.
pub fn of_run(args: &ExportArgs) -> Result<Outputs<'static>, OutputError> {
    let mut created = CreatedFiles::default();
    args.output.iter().try_for_each(|folder| created.folder(folder))?;
    let mut outputs = Outputs::new(args.output.clone(), created);
    for (name, format) in IN_FOLDER {
        outputs.add_in_folder(name, format)?;
    }
    for (path, format) in series_files(args) {
        let select = args.export_select.clone();
        outputs.add(path.clone(), move |run| format(run, select.as_ref()))?;
    }
    Ok(outputs)
}

/// A number of a row of a scene.
#[derive(Debug, Clone, PartialEq)]
pub struct Measure {
    /// Scene and row: `teapot: uniform-grid density=1`.
    pub row: String,
    /// As in [`METRICS`]; of rates `mrays-primary` and so on.
    pub name: String,
    pub unit: &'static str,
    /// The value; of what was measured, the median.
    pub value: f64,
    /// The ends of the 95% interval, of what was measured.
    pub interval: Option<[f64; 2]>,
}

/// Filter of exported series, matched against `SCENE: STRUCTURE SETTINGS / NAME`; `None` for all.
pub type Select<'a> = Option<&'a Regex>;

impl Measure {
    /// As charts call it.
    pub fn series(&self) -> String {
        format!("{} / {}", self.row, self.name)
    }

    fn is_selected(&self, select: Select<'_>) -> bool {
        select.is_none_or(|select| select.is_match(&self.series()))
    }
}

/// Times, ratios and counters: the metrics of every timed row that are costs. Smaller is better.
pub fn costs(run: &RunRecord, select: Select<'_>) -> Vec<Measure> {
    let mut measures = Vec::new();
    for scene in &run.scenes {
        let has_ratios = reference::is_over(scene, &run.settings.reference);
        for row in scene.rows.iter().filter(|row| row.verdict.is_timed()) {
            // rates have the kinds of rays
            let of_all = METRICS.iter().filter(|m| !matches!(m.reading, Reading::RatioOf(_)));
            // of what is no cost, less is not better
            let of_all = of_all.filter(|m| m.is_cost && (has_ratios || !m.is_to_reference()));
            for metric in of_all {
                let found = metric.values(scene, row).estimate(run.settings.seed);
                let Some(found) = found else { continue };
                let is_exact = metric.is_exact();
                measures.push(Measure {
                    row: name_of(&scene.name, row),
                    name: metric.name.to_owned(),
                    unit: match metric.unit {
                        "" if is_exact => "count",
                        "" => "ratio",
                        unit => unit,
                    },
                    value: found.median,
                    interval: (!is_exact).then_some([found.low, found.high]),
                });
            }
        }
    }
    measures.retain(|m| m.is_selected(select));
    measures
}

/// Millions of rays per second by kind, of every timed row. Bigger is better.
pub fn rates(run: &RunRecord, select: Select<'_>) -> Vec<Measure> {
    let mut measures = Vec::new();
    for scene in &run.scenes {
        for row in scene.rows.iter().filter(|row| row.verdict.is_timed()) {
            for (kind, &rays) in &row.rays_by_kind {
                let seconds = series(row, |s| s.trace_s.get(kind).copied());
                let found = seconds.estimate(run.settings.seed);
                let Some(found) = found.filter(|seconds| seconds.low > 0.0) else { continue };
                let rate = |seconds: f64| rays as f64 / seconds / 1e6;
                measures.push(Measure {
                    row: name_of(&scene.name, row),
                    name: format!("mrays-{kind}"),
                    unit: "Mrays/s",
                    value: rate(found.median),
                    interval: Some([rate(found.high), rate(found.low)]),
                });
            }
        }
    }
    measures.retain(|m| m.is_selected(select));
    measures
}

/// The series that a plan will have, but for rows that are wrong or not built.
pub fn series_of(plan: &Plan<'_>) -> Vec<String> {
    let costs = METRICS.iter().filter(|m| m.is_cost && !matches!(m.reading, Reading::RatioOf(_)));
    let rates = plan.kinds.iter().flat_map(|kind| {
        let orders = plan.orders.orders().iter();
        orders.map(|order| format!("mrays-{}", batch_name(kind.name(), *order)))
    });
    let names: Vec<String> = costs.map(|metric| metric.name.to_owned()).chain(rates).collect();
    let rows = plan
        .scenes
        .iter()
        .flat_map(|scene| plan.rows.iter().map(|row| format!("{}: {}", scene.name(), row.label())));
    rows.flat_map(|row| names.iter().map(move |name| format!("{row} / {name}")).collect::<Vec<_>>())
        .collect()
}

fn name_of(scene: &str, row: &RowRecord) -> String {
    format!("{scene}: {}", row.label())
}

#[derive(Debug, Serialize)]
struct Metric {
    value: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    lower_value: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    upper_value: Option<f64>,
}

/// Times, ratios, counters and rays per second.
pub fn bencher(run: &RunRecord, select: Select<'_>) -> Result<String, FormatError> {
    let mut benchmarks: BTreeMap<String, BTreeMap<String, Metric>> = BTreeMap::new();
    for m in costs(run, select).into_iter().chain(rates(run, select)) {
        let [lower_value, upper_value] = [m.interval.map(|i| i[0]), m.interval.map(|i| i[1])];
        let metric = Metric { value: m.value, lower_value, upper_value };
        benchmarks.entry(m.row).or_default().insert(m.name, metric);
    }
    json::written(&benchmarks)
}

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
