//! An axis as tables and CSV, whose columns stand here one line each, and as a plot: time against
//! error, the front pointed out, one panel per scene.

use std::fmt::Write;

use presentation::column::{self, Column, Unit, Value};
use presentation::json::FormatError;
use presentation::markdown::{escaped, push_table_with};
use presentation::numbers::short;
use presentation::svg_plot::{Axis, Level, Mark, Plot, Point, Scale, Series, figure};
use presentation::table::{Cell, Style, Table};
use statistics::estimate::Estimate;

use crate::accuracy::record::{
    AccuracyRecord, AxisRecord, ErrorOf, PartTime, SceneOutcome, VariantRecord, VariantStanding,
};

/// The columns of [`columns`] that a table has, in its order.
const HEADS: [&str; 6] = ["variant", "time ms", "ratio [95%]", "error", "also", "stands"];

pub const GLOSSARY: &[&str] = &[
    "time: of the work named below the table, median over interleaved rounds; ratio: to the cheapest \
     variant in the same rounds, with its 95% interval (bootstrap; of several processes Student's), = where \
     it contains 1; (in parentheses): left out; not a variant, may take less time than the cheapest; error: by the axis' metric, where it is a rate in 10^6 with its count, and with the bound 3/trials where \
     nothing was wrong.",
    "front: no other variant is as accurate and as fast, and better in one of both; ~front: \
     beaten only by variants whose time is not significantly different; ref: the variant (or one of its answers) \
     that the others are compared with.",
];

pub fn table(axis: &AxisRecord, scene: &SceneOutcome) -> Table {
    let mut notes = vec![
        format!("Timed: {}. Judged: {}.", scene.timed, scene.judged),
        format!("Error: {}. Reference: {}.", axis.metric, axis.reference),
    ];
    if scene.reference_error > 0.0 {
        notes.push(format!("The reference's own error: {:.2e}.", scene.reference_error));
    }
    notes.extend(scene.faults.iter().map(|fault| format!("FAULT: {fault}.")));
    Table {
        title: format!("{}: {}", axis.axis, scene.place()),
        notes,
        ..column::table(&columns(), &HEADS, rows(axis, scene))
    }
}

/// All tables in Markdown, with where and how they were made.
pub fn to_markdown(run: &AccuracyRecord) -> String {
    let mut text = String::from("# What accuracy costs in time: all variants\n\n");
    push_facts(&mut text, run);
    for (axis, scene) in run.scenes() {
        push_table(&mut text, &table(axis, scene));
    }
    for line in GLOSSARY {
        let _ = writeln!(text, "{line}\n");
    }
    text
}

/// Appends a table with its title and notes.
pub(super) fn push_table(text: &mut String, table: &Table) {
    push_table_with(text, table, |column| (1..=3).contains(&column));
}

pub fn facts(run: &AccuracyRecord) -> [String; 5] {
    let known = |text: &Option<String>| text.clone().unwrap_or_else(|| "unknown".to_owned());
    let AccuracyRecord { machine, compiler, tool, seed, processes, rounds, .. } = run;
    let (cpu, revision) = (known(&machine.cpu), known(&tool.git_revision));
    let (rustc, level) = (known(&compiler.rustc), known(&compiler.opt_level));
    let of = if *processes > 1 { format!("{processes} processes of ") } else { String::new() };
    let took = took(run.took_s);
    [
        format!("command: {}", run.command_line.join(" ")),
        format!("machine: {cpu}, {} threads, {}", machine.threads, machine.os),
        format!("compiler: {rustc}, opt-level {level}"),
        format!("rtbench {} at {revision}", tool.version),
        format!("seed {seed}, {of}{rounds} rounds, one thread; {took} in all"),
    ]
}

pub(super) fn push_facts(text: &mut String, run: &AccuracyRecord) {
    for fact in facts(run) {
        let _ = writeln!(text, "- {}", escaped(&fact));
    }
    text.push('\n');
}

pub fn took(seconds: f64) -> String {
    let whole = seconds.round() as u64;
    match whole / 60 {
        0 => format!("{whole} s"),
        minutes => format!("{minutes} min {} s", whole % 60),
    }
}

#[derive(Debug, Clone, Copy)]
pub struct VariantRow<'a> {
    pub axis: &'a AxisRecord,
    pub scene: &'a SceneOutcome,
    pub row: &'a VariantRecord,
}

impl VariantRow<'_> {
    /// Value from the numbers of wrong and all answers, if answers were counted.
    fn counted(&self, which: fn(u64, u64) -> u64) -> Value {
        match self.row.error {
            ErrorOf::Counted { wrong, trials } => Value::Count(which(wrong, trials)),
            ErrorOf::Rmse { .. } => Value::None,
        }
    }
}

/// All columns, in the order of the CSV file.
#[rustfmt::skip]
pub fn columns<'a>() -> [Column<VariantRow<'a>>; 19] {
    use Unit::{None, Ratio, Seconds};
    use Value::{Measured, Real, Text};
    let c = Column::new;
    [
        c(&["axis"], "", None, |of: &VariantRow<'a>| Text(of.axis.axis.clone())),
        c(&["scene"], "", None, |of| Text(of.scene.scene.clone())),
        c(&["subject"], "", None, |of| Text(of.scene.subject.clone())),
        c(&["variant"], "variant", None, |of| Text(of.row.variant.clone()))
            .or(|of| of.row.is_without.then(|| format!("({})", of.row.variant).into())),
        c(&["setting"], "", None, |of| Text(of.row.setting.clone())),
        c(&["metric"], "", None, |of| Text(of.axis.metric.clone())),
        c(&["reference"], "", None, |of| Text(of.axis.reference.clone())),
        c(&["error"], "error", None, |of| Real(of.row.error.value())).exact()
            .or(|of| Some(error(of.row).into())),
        c(&["wrong"], "", None, |of| of.counted(|wrong, _| wrong)),
        c(&["trials"], "", None, |of| of.counted(|_, trials| trials)),
        c(&["reference_error"], "", None, |of| Real(of.scene.reference_error)).exact(),
        c(&["below_reference"], "", None, |of| Text(of.row.is_below_reference.to_string())),
        c(&["time_s", "time_s_low", "time_s_high"], "time ms", Seconds, |of| Measured(of.row.time_s)).exact(),
        c(&["ratio_to_cheapest", "ratio_low", "ratio_high"], "ratio [95%]", Ratio, |of| Measured(of.row.ratio)).exact(),
        c(&["standing"], "stands", None, |of| Text(of.row.standing.name().to_owned()))
            .or(|of| Some(standing(of.row))),
        c(&["is_reference"], "", None, |of| Text(of.row.is_reference.to_string())),
        c(&["also"], "also", None, |of| {
            Text(joined(&of.row.also, "; ", |(name, x)| format!("{name}={x}")))
        }).or(|of| Some(also(of).into())),
        c(&["seconds"], "", None, |of| Text(seconds(&of.row.seconds))),
        c(&["parts"], "", None, |of| {
            let part = |part: &PartTime| format!("{}={}", part.part, seconds(&part.seconds));
            Text(joined(&of.row.parts, "; ", part))
        }),
    ]
}

pub fn to_csv(run: &AccuracyRecord) -> Result<String, FormatError> {
    column::csv(&columns(), run.scenes().flat_map(|(axis, scene)| rows(axis, scene)))
}

pub fn rows<'a>(
    axis: &'a AxisRecord,
    scene: &'a SceneOutcome,
) -> impl Iterator<Item = VariantRow<'a>> {
    scene.rows.iter().map(move |row| VariantRow { axis, scene, row })
}

fn error(row: &VariantRecord) -> String {
    if row.is_below_reference {
        return format!("below reference ({:.1e})", row.error.value());
    }
    match (row.error, row.error.bound()) {
        (_, Some(bound)) => format!("0 (< {})", short(bound)),
        (ErrorOf::Counted { wrong, trials }, None) => {
            format!("{} ({wrong} of {trials})", short(row.error.value()))
        }
        (ErrorOf::Rmse { rmse: 0.0 }, None) => "0".into(),
        (ErrorOf::Rmse { rmse }, None) => format!("{rmse:.2e}"),
    }
}

fn standing(row: &VariantRecord) -> Cell {
    let style = if row.standing == VariantStanding::OnFront { Style::Best } else { Style::Plain };
    let reference = if row.is_reference { " ref" } else { "" };
    Cell { text: format!("{}{reference}", row.standing.name()), style }
}

/// Further figures of a scene's variants, named as in the first one.
fn also(of: &VariantRow<'_>) -> String {
    let names = of.scene.rows.iter().take(1).flat_map(|first| first.also.keys());
    joined(names, ", ", |name| {
        format!("{} {name}", of.row.also.get(name).map_or("-".into(), |x| short(*x)))
    })
}

fn seconds(rounds: &[f64]) -> String {
    joined(rounds, " ", |s| format!("{s:e}"))
}

fn joined<T>(all: impl IntoIterator<Item = T>, between: &str, say: impl Fn(T) -> String) -> String {
    all.into_iter().map(say).collect::<Vec<_>>().join(between)
}

/// From this ratio of the largest to the smallest on, an axis is logarithmic.
const WIDE: f64 = 8.0;

pub fn to_svg(axis: &AxisRecord) -> String {
    let panels: Vec<Plot> = axis.scenes.iter().map(|scene| panel(axis, scene)).collect();
    figure(&panels)
}

pub fn panel(axis: &AxisRecord, scene: &SceneOutcome) -> Plot {
    let floor = floor(scene);
    let error = |row: &VariantRecord| match row.error.value() {
        e if e > 0.0 => e,
        _ => floor.unwrap_or(0.0),
    };
    let is_log = floor.is_some();
    let point = |row: &VariantRecord| {
        let Estimate { median: y, low, high } = row.ratio;
        Point { x: error(row), y, low, high }
    };
    let mut front: Vec<Point> =
        scene.rows.iter().filter(|r| r.standing == VariantStanding::OnFront).map(point).collect();
    front.sort_by(|a, b| a.x.total_cmp(&b.x));
    let mark = |row: &VariantRecord| Mark {
        hover: String::new(),
        point: point(row),
        label: row.variant.clone(),
        ring: row.standing.ring(),
        is_in_series: row.standing == VariantStanding::OnFront,
    };
    let slowest = scene.rows.iter().map(|r| r.ratio.median).fold(1.0, f64::max);
    let has_zero = is_log && scene.rows.iter().any(|r| r.error.value() == 0.0);
    let mut subtitle = format!("timed: {}; bars: 95% intervals", scene.timed);
    if has_zero {
        subtitle.push_str("; errors of 0 stand at the left end");
    }
    let mut levels = vec![Level { y: 1.0, label: "cheapest variant = 1".into() }];
    levels.truncate(usize::from(slowest.is_finite()));
    Plot {
        title: format!("{}: {}", axis.axis, scene.place()),
        subtitle,
        x: Axis {
            label: axis.metric.clone(),
            scale: if is_log { Scale::Log } else { Scale::FromZero },
        },
        y: Axis {
            label: "time / time of the cheapest variant".into(),
            scale: if slowest >= WIDE { Scale::Log } else { Scale::FromZero },
        },
        series: vec![Series { name: "Pareto front".into(), points: front, is_joined: true }],
        marks: scene.rows.iter().map(mark).collect(),
        marks_name: "dominated".into(),
        levels,
    }
}

/// Position of errors of 0 on a logarithmic axis: half the bound given by the number of trials, or
/// a third of the least error; `None` if no error is above 0.
fn floor(scene: &SceneOutcome) -> Option<f64> {
    let least = scene.rows.iter().map(|r| r.error.value()).filter(|e| *e > 0.0).reduce(f64::min)?;
    let bound = scene.rows.iter().find_map(|row| match row.error {
        ErrorOf::Counted { .. } => row.error.bound(),
        ErrorOf::Rmse { .. } => None,
    });
    Some(bound.map_or(least / 3.0, |b| (b / 2.0).min(least / 3.0)))
}
