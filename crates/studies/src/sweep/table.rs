//! A sweep as a table and CSV: the columns of a run that vary, values down.

use std::io::{self, Write};

use accel_core::params::ParamKind;

use crate::run::columns::RATIO;
use crate::run::{columns as run_columns, markdown, tables};
use crate::sweep::judgement::{Judgement, ValueStanding, judge};
use crate::sweep::{Line, Sweep};
use measurement::record::{RunRecord, SceneRecord, Verdict};
use presentation::csv::{self, written};
use presentation::json::FormatError;
use presentation::numbers;
use presentation::table::{Cell, Style, Table};
use presentation::text::Screen;

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

/// Prints the table of a scene.
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
    markdown::document("rtbench sweep", run, &tables, GLOSSARY)
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
    x.map_or(Cell { text: "-".into(), style: Style::Dim }, |x| numbers::short(x).into())
}

/// Best value, and its advantage.
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
