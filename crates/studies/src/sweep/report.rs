//! A sweep as a table and CSV, the columns of a run that vary, values down; and as a plot: tracing time
//! over the values, rules of thumb beside them.

use std::io::{self, Write};

use accel_core::params::ParamKind;
use measurement::record::{RunRecord, SceneRecord, Verdict, reference};
use presentation::csv::{self, written};
use presentation::json::FormatError;
use presentation::numbers;
use presentation::svg_plot::{Axis, Level, Mark, Plot, Point, Ring, Scale, Series, figure};
use presentation::table::{Cell, Style, Table, dash};
use presentation::text::Screen;

use crate::run::columns::RATIO;
use crate::run::{columns as run_columns, output, tables};
use crate::sweep::judgement::{Judgement, ValueStanding, costs, judge};
use crate::sweep::{Line, Sweep};

/// Columns taken from the table of a run.
#[rustfmt::skip]
const TAKEN: [&str; 15] = [
    "N_V", "N_EV", "N_OIV", "MiB", "build ms", "rays", "trace ms", "N_IT", "N_TS", RATIO, "verdict",
    "primary", "shadow", "second.", "diffuse",
];

/// Columns of most weight: these stay where not all fit. The verdict comes before all where one is
/// not `ok`.
const FIRST: [&str; 9] =
    ["verdict", RATIO, "mark", "to best", "N_IT", "N_TS", "build ms", "trace ms", "MiB"];

pub fn write(
    out: &mut dyn Write,
    sweep: &Sweep<'_>,
    run: &RunRecord,
    scene: &SceneRecord,
    screen: Screen,
) -> io::Result<()> {
    let all_right = scene.rows.iter().all(|row| row.verdict == Verdict::Ok);
    screen.write_fitted(out, &scene_table(sweep, run, scene), &FIRST[usize::from(all_right)..])
}

pub fn to_markdown(sweep: &Sweep<'_>, run: &RunRecord) -> String {
    let tables: Vec<Table> =
        run.scenes.iter().map(|scene| scene_table(sweep, run, scene)).collect();
    output::document("rtbench sweep", run, &tables, GLOSSARY)
}

fn scene_table(sweep: &Sweep<'_>, run: &RunRecord, scene: &SceneRecord) -> Table {
    let measured = tables::scene_table(run, scene, &scene.rows, false);
    let judgements = judge(sweep, scene);
    let taken: Vec<(usize, &'static str)> = TAKEN
        .iter()
        .filter_map(|name| Some((measured.header.iter().position(|h| h == name)?, *name)))
        .collect();
    let mut header = vec![sweep.parameter.name, "cells/prim"];
    header.extend(taken.iter().map(|(_, name)| *name));
    header.extend(["to best", "mark"]);
    let rows = measured.rows.iter().zip(&sweep.lines).zip(&judgements).zip(&scene.rows);
    let rows = rows.map(|(((cells, line), judgement), row)| {
        let mut out: Vec<Cell> = vec![name(line, &row.label()).into()];
        out.push(number(judgement.cells_per_primitive));
        out.extend(taken.iter().filter_map(|&(column, name)| {
            Some(restyled(cells.get(column)?, name == RATIO, judgement))
        }));
        out.push(number(judgement.to_best));
        out.push(judgement.marks.join(", ").into());
        out
    });
    let mut notes: Vec<String> = best_notes(sweep, &judgements);
    notes.extend(measured.notes.iter().cloned());
    Table { title: title(sweep, &measured.title), header, rows: rows.collect(), notes }
}

fn title(sweep: &Sweep<'_>, scene: &str) -> String {
    let structure = format!("{} {}", sweep.structure, sweep.settings);
    format!("{} of {} on {scene}", sweep.parameter.name, structure.trim_end())
}

/// The value, or the settings of a row that has none.
fn name(line: &Line, label: &str) -> String {
    line.value.clone().unwrap_or_else(|| label.to_owned())
}

/// A run's cell; which ratio is the best is not judged as in a run.
fn restyled(cell: &Cell, is_ratio: bool, judgement: &Judgement) -> Cell {
    let style = match (is_ratio, cell.style) {
        (true, Style::Plain | Style::Best) if judgement.standing == Some(ValueStanding::Best) => {
            Style::Best
        }
        (true, Style::Best) => Style::Plain,
        (_, style) => style,
    };
    Cell { text: cell.text.clone(), style }
}

fn number(x: Option<f64>) -> Cell {
    x.map_or_else(dash, |x| numbers::short(x).into())
}

pub fn best_notes(sweep: &Sweep<'_>, judgements: &[Judgement]) -> Vec<String> {
    let of = |standing| {
        let lines = sweep.lines.iter().zip(judgements);
        let lines = lines.filter(move |(_, j)| j.standing == Some(standing));
        lines.filter_map(|(line, _)| line.value.as_deref())
    };
    let parameter = sweep.parameter.name;
    let Some(best) = of(ValueStanding::Best).next() else {
        return vec![format!("No value of {parameter} has a time.")];
    };
    let equal: Vec<&str> = of(ValueStanding::NotToldApart).collect();
    let mut notes = vec![if equal.is_empty() {
        format!("Best: {parameter}={best}.")
    } else {
        format!("Best: {parameter}={best}; not significantly different: {}.", equal.join(", "))
    }];
    let mut swept = sweep.lines.iter().filter(|l| l.is_swept).filter_map(|l| l.value.as_deref());
    let ends = [swept.next(), swept.next_back()];
    // others have no order
    let has_numbers =
        matches!(sweep.parameter.kind, ParamKind::Integer { .. } | ParamKind::Real { .. });
    if has_numbers && ends.contains(&Some(best)) {
        let end =
            "The best value is at an end of those measured: a wider range may have a better one.";
        notes.push(end.into());
    }
    notes
}

pub const GLOSSARY: &[&str] = &[
    "cells/prim: N_V for each primitive. N_V elementary cells, N_EV empty ones, N_OIV references in \
     cells; per ray: N_IT intersection tests, N_TS traversal steps. build, trace: medians over the \
     rounds; trace is the time for the rays of the column beside it, all kinds together; primary, \
     shadow, second., diffuse: millions of rays per second of one kind.",
    "ratio: trace time divided by the reference's for the same rays in the same round, with its 95% \
     bootstrap interval; below 1 is faster; = where the interval contains 1. to best: that ratio over \
     the best value's.",
    "best: the value with the lowest ratio; ~best: not significantly different (its interval \
     overlaps that of the best). rule: a rule of thumb for the number of voxels of N primitives (the \
     rules regular, woo and heterogeneous at one voxel per primitive; regular is the cube root of N \
     on each axis).",
];

/// The columns before those of a run.
const OWN: [&str; 5] = ["parameter", "value", "marks", "cells_per_primitive", "to_best"];

/// All finished scenes: the parameter, its value and the marks, then the columns of a run.
pub fn to_csv(sweep: &Sweep<'_>, run: &RunRecord) -> Result<String, FormatError> {
    written(|writer| {
        writer.write_record(OWN.into_iter().chain(run_columns::keys()))?;
        for scene in &run.scenes {
            let judgements = judge(sweep, scene);
            for ((row, line), judgement) in scene.rows.iter().zip(&sweep.lines).zip(judgements) {
                let mut fields = vec![
                    sweep.parameter.name.to_owned(),
                    line.value.clone().unwrap_or_default(),
                    judgement.marks.join("; "),
                    csv::number(judgement.cells_per_primitive),
                    csv::number(judgement.to_best),
                ];
                fields.extend(run_columns::fields(scene, row));
                writer.write_record(fields)?;
            }
        }
        Ok(())
    })
}

/// From this ratio of the slowest to the fastest on, the time axis is logarithmic.
const WIDE: f64 = 8.0;

pub fn to_svg(sweep: &Sweep<'_>, run: &RunRecord) -> String {
    let panels: Vec<Plot> = run.scenes.iter().map(|scene| panel(sweep, run, scene)).collect();
    figure(&panels)
}

/// A row that has a time, and where it lies.
struct PlottedRow<'a> {
    line: &'a Line,
    judgement: &'a Judgement,
    point: Point,
}

fn panel(sweep: &Sweep<'_>, run: &RunRecord, scene: &SceneRecord) -> Plot {
    let judgements = judge(sweep, scene);
    let rows = scene.rows.iter().zip(&sweep.lines).zip(&judgements).zip(costs(scene));
    let placed: Vec<PlottedRow<'_>> = rows
        .filter(|(((row, _), _), _)| row.verdict == Verdict::Ok)
        .filter_map(|(((_, line), judgement), cost)| {
            let (x, cost) = (abscissa(sweep, line, judgement)?, cost?);
            let point = Point { x, y: cost.median, low: cost.low, high: cost.high };
            Some(PlottedRow { line, judgement, point })
        })
        .collect();
    let has_ratios = scene.rows.iter().any(|r| r.ratio.is_some());
    let settings = format!("{} {}", sweep.structure, sweep.settings);
    let rays = scene.distinct_rays();
    let reference = reference::of_scene(scene).unwrap_or_else(|| run.settings.reference.clone());
    let mut swept: Vec<Point> =
        placed.iter().filter(|p| p.line.is_swept).map(|p| p.point).collect();
    swept.sort_by(|a, b| a.x.total_cmp(&b.x));
    let reference_level = has_ratios.then(|| Level { y: 1.0, label: format!("{reference} = 1") });
    Plot {
        title: format!("{}: {} of {}", scene.name, sweep.parameter.name, settings.trim_end()),
        subtitle: subtitle(scene, rays, sweep, &judgements),
        x: sweep.axis.clone(),
        y: Axis {
            label: if has_ratios {
                format!("trace time / trace time of {reference}")
            } else {
                "trace time per ray (seconds)".to_owned()
            },
            scale: vertical(&placed),
        },
        series: vec![Series {
            name: format!("values of {}", sweep.parameter.name),
            points: swept,
            is_joined: !matches!(sweep.axis.scale, Scale::Words(_)),
        }],
        marks: placed.iter().filter_map(mark).collect(),
        marks_name: if sweep.has_rules {
            "for comparison: default and rules of thumb".to_owned()
        } else {
            "for comparison: default".to_owned()
        },
        levels: reference_level.into_iter().chain(default_level(sweep, &placed)).collect(),
    }
}

/// The default as a level where its value has no place: 0 on a logarithmic axis.
fn default_level(sweep: &Sweep<'_>, placed: &[PlottedRow<'_>]) -> Option<Level> {
    let is_log = !sweep.has_rules && sweep.axis.scale == Scale::Log;
    let default = placed.iter().find(|p| is_log && p.line.is_default && p.point.x <= 0.0)?;
    let value = default.line.value.as_deref().unwrap_or_default();
    Some(Level { y: default.point.y, label: format!("default: {value}") })
}

fn subtitle(scene: &SceneRecord, rays: u64, sweep: &Sweep<'_>, judgements: &[Judgement]) -> String {
    let mut text =
        format!("{} primitives, {rays} rays; medians with 95% intervals", scene.primitives);
    let hidden: Vec<&str> = scene
        .rows
        .iter()
        .zip(&sweep.lines)
        .filter(|(row, _)| row.verdict != Verdict::Ok)
        .filter_map(|(_, line)| line.value.as_deref().or(line.rules.first().copied()))
        .collect();
    if !hidden.is_empty() {
        text.push_str(&format!("; wrong or not built: {}", hidden.join(", ")));
    }
    let has_equals = judgements.iter().any(|j| j.standing == Some(ValueStanding::NotToldApart));
    if has_equals {
        text.push_str("; dashed rings: not significantly different from the best");
    }
    text
}

/// Position of a row on the horizontal axis; `None` for the reference.
fn abscissa(sweep: &Sweep<'_>, line: &Line, judged: &Judgement) -> Option<f64> {
    let value = line.value.as_ref();
    if sweep.has_rules {
        let is_own = value.is_some() || !line.rules.is_empty();
        return judged.cells_per_primitive.filter(|_| is_own);
    }
    match &sweep.axis.scale {
        Scale::Words(words) => Some(words.iter().position(|w| Some(w) == value)? as f64),
        _ => value?.parse().ok(),
    }
}

fn vertical(placed: &[PlottedRow<'_>]) -> Scale {
    let times = || placed.iter().map(|p| p.point.y);
    let fastest = times().fold(f64::INFINITY, f64::min);
    let slowest = times().fold(0.0, f64::max);
    if fastest > 0.0 && slowest / fastest >= WIDE { Scale::Log } else { Scale::FromZero }
}

/// Mark for the best value and those as good, the default, the rules of thumb.
fn mark(placed: &PlottedRow<'_>) -> Option<Mark> {
    let ring = match placed.judgement.standing {
        Some(ValueStanding::Best) => Ring::Best,
        Some(ValueStanding::NotToldApart) => Ring::AsGood,
        Some(ValueStanding::Slower) | None => Ring::None,
    };
    let marks = placed.judgement.marks.iter().map(String::as_str);
    // The dashed ring says the one, the other is a row of its own kind.
    let marks: Vec<&str> = marks.filter(|m| !["~best", "reference"].contains(m)).collect();
    let mut label = marks.join(", ");
    if let (true, true, Some(value)) = (placed.line.is_swept, !label.is_empty(), &placed.line.value)
    {
        label = format!("{label}: {value}");
    }
    let is_in_series = placed.line.is_swept;
    let is_marked = !label.is_empty() || ring != Ring::None;
    let (point, hover) = (placed.point, String::new());
    is_marked.then_some(Mark { point, label, hover, ring, is_in_series })
}
