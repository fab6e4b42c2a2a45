//! `rtbench reproduce`: published figures beside ours.

use crate::args::{HavranArgs, Publication, ZachmannArgs};
use crate::commands::measuring::{exit_code, measure_scenes};
use crate::context::Context;
use crate::error::{Error, FAILURE, SUCCESS};
use measurement::plan::Plan;
use measurement::plan::error::chosen;
use measurement::plan::rows::Row;
use measurement::record::{RunRecord, Verdict as RowVerdict};
use measurement::settings::MeasuringSettings;
use measurement::system::files::write_text;
use presentation::column::{self, Column, Unit, Value};
use presentation::csv;
use presentation::numbers::short;
use presentation::table::{Cell, Style, Table, dash, words};
use renderer::RayKind;
use studies::reproduce::lecture::{
    self, Comparison, Line, MODERN, Ratios, STRUCTURES, SYMBOLS, SecondsTable, measured_seconds,
    published, published_seconds,
};
use studies::reproduce::published::{Figure, SCENES, figures};
use studies::reproduce::verdict::Verdict;
use studies::reproduce::{ReproduceError, ReproducedRow, reproduce_scene, structures};

/// Reproduces the publication and returns the exit code.
pub fn run(context: &mut Context<'_>, publication: &Publication) -> Result<u8, Error> {
    match publication {
        Publication::Havran1999(args) => havran(context, args),
        Publication::Zachmann2007(args) => zachmann(context, args),
    }
}

/// The files of `-o`, by publication.
pub const HAVRAN: &str = "havran1999.csv";
pub const ZACHMANN: &str = "zachmann2007.csv";

/// Reproduces scene after scene, prints the table of a scene as soon as it is done, and the
/// sums; with `--strict` an unexplained difference is a failure.
fn havran(context: &mut Context<'_>, args: &HavranArgs) -> Result<u8, Error> {
    let scenes = chosen("scene of the publication", &args.scenes, &SCENES, |name| name)?;
    let structures = chosen("published structure", &args.structures, &structures(), |name| name)?;
    let _created = context.created_folder(args.output.as_ref(), &[HAVRAN])?;
    let figures = figures().map_err(ReproduceError::from)?;
    let mut rows = Vec::new();
    let screen = context.plain_screen();
    for scene in scenes {
        context.say(format_args!("{scene}: counting"));
        let of_scene = reproduce_scene(scene, &structures, &figures)?;
        screen.write_fitted(context.out, &figures_table(scene, &of_scene), &[])?;
        rows.extend(of_scene);
    }
    screen.write_line(context.out, &sums(&rows))?;
    if let Some(folder) = &args.output {
        let text = csv::written(|writer| rows.iter().try_for_each(|row| writer.serialize(row)))?;
        write_text(&folder.join(HAVRAN), &text)?;
    }
    let unexplained = rows.iter().any(|r| r.verdict == Verdict::Unexplained);
    Ok(if args.strict && unexplained { FAILURE } else { SUCCESS })
}

fn figures_table(scene: &str, rows: &[ReproducedRow]) -> Table {
    let cells = rows.iter().map(|row| {
        let decimals = if row.ours.fract() == 0.0 { 0 } else { 3 };
        vec![
            format!("{} {}: {}", row.structure, row.params, row.counter),
            row.published.clone(),
            format!("{:.decimals$}", row.ours),
            format!("{:.4}", row.ratio),
            row.verdict.to_string(),
        ]
    });
    words(scene, vec!["figure", "published", "ours", "ratio", "verdict"], cells)
}

fn sums(rows: &[ReproducedRow]) -> String {
    let count = |of: fn(&Verdict) -> bool| rows.iter().filter(|r| of(&r.verdict)).count();
    format!(
        "{} figures: {} exact, {} within tolerance, {} differ for a known reason, {} unexplained",
        rows.len(),
        count(|v| *v == Verdict::Exact),
        count(|v| *v == Verdict::Within),
        count(|v| matches!(v, Verdict::KnownReason(_))),
        count(|v| *v == Verdict::Unexplained),
    )
}

/// Measures the lecture's structures, prints one table per scene and all verdicts at the end.
fn zachmann(context: &mut Context<'_>, args: &ZachmannArgs) -> Result<u8, Error> {
    let scenes = chosen("scene of the lecture", &args.scenes, &lecture::SCENES, |name| name)?;
    let plan = plan(context, args.measuring.settings(), &scenes)?;
    let published = published().map_err(ReproduceError::from)?;
    let rows = |run: &RunRecord| {
        let comparisons = comparisons(run, &published);
        column::csv(&columns(), comparisons.iter().flat_map(of_scene))
    };
    let outputs = context.outputs_in(args.output.as_ref(), [(ZACHMANN, Box::new(rows))])?;
    let screen = context.plain_screen();
    let measured = measure_scenes(context, &plan, outputs, |out, _, scene| {
        let table = table(&Comparison::new(scene, &published));
        if args.as_published { Ok(()) } else { screen.write_fitted(out, &table, &["ours"]) }
    })?;
    if args.as_published {
        // an interrupted run has the first of them
        let scenes: Vec<&str> = scenes.into_iter().take(measured.record.scenes.len()).collect();
        for symbol in SYMBOLS {
            let then = published_seconds(&published, &scenes, symbol);
            let now = measured_seconds(&measured.record.scenes, symbol);
            let title = |of: &str| format!("{symbol}, {of}");
            let then = seconds_table(title("the slides"), &scenes, then, |s| s.to_string());
            let now = seconds_table(title("this machine"), &scenes, now, short);
            screen.write_fitted(context.out, &then, &[])?;
            screen.write_fitted(context.out, &now, &[])?;
        }
    }
    for comparison in comparisons(&measured.record, &published) {
        screen.write_line(context.out, &comparison.sentence())?;
    }
    Ok(exit_code(&measured))
}

/// Structures down and scenes across, as the slides have them.
fn seconds_table(
    title: String,
    scenes: &[&'static str],
    table: SecondsTable,
    text: fn(f64) -> String,
) -> Table {
    let cell = |seconds: &Option<f64>| seconds.map_or_else(dash, |s| Cell::from(text(s)));
    let line = |(name, seconds): (&str, Vec<Option<f64>>)| {
        std::iter::once(Cell::from(name.to_owned())).chain(seconds.iter().map(cell)).collect()
    };
    let rows = table.into_iter().map(line).collect();
    Table { title, header: [&["structure"], scenes].concat(), rows, notes: Vec::new() }
}

/// The lecture's structures and the modern one, on the kinds of rays that the lecture's images
/// needed unless others are asked for.
fn plan<'r>(
    context: &Context<'r>,
    mut args: MeasuringSettings,
    scenes: &[&str],
) -> Result<Plan<'r>, Error> {
    if args.rays.is_empty() {
        let kinds = RayKind::ALL.into_iter().filter(|k| *k != RayKind::Diffuse);
        args.rays = kinds.map(|k| k.name().to_owned()).collect();
    }
    let names: Vec<String> = scenes.iter().map(|&s| s.to_owned()).collect();
    let rows = STRUCTURES.iter().map(|(_, row)| *row).chain([MODERN]);
    let rows = rows.map(|row| Row::parse(context.registry, row)).collect::<Result<Vec<_>, _>>()?;
    let mut plan = Plan::over(context.scenes.resolve(&names)?, rows, 0, &args, context.registry)?;
    // the lecture's ratios are to that row
    plan.keeps_baseline = true;
    Ok(plan)
}

fn comparisons(run: &RunRecord, published: &[Figure]) -> Vec<Comparison> {
    run.scenes.iter().map(|scene| Comparison::new(scene, published)).collect()
}

/// A structure on a scene, by name.
type SceneLine<'a> = (&'a str, &'a Line);

/// All columns, in the order of the CSV file.
#[rustfmt::skip]
fn columns<'a>() -> [Column<SceneLine<'a>>; 8] {
    use Unit::{None, Ratio};
    let c = Column::new;
    [
        c(&["scene"], "", None, |(scene, _)| Value::Text((*scene).to_owned())),
        c(&["lecture"], "lecture", None, |(_, line)| Value::of(line.lecture, |name| Value::Text(name.to_owned()))),
        c(&["ours"], "ours", None, |(_, line)| Value::Text(line.ours.clone())),
        c(&["verdict"], "", None, |(_, line)| Value::Text(line.verdict.name().to_owned())),
        c(&["build_then"], "build then", None, |(_, line)| Value::of(line.build.then, Value::Real)),
        c(&["build_now", "build_low", "build_high"], "build now [95%]", Ratio, |(_, line)| {
            Value::of(line.build.now, Value::Measured)
        }).or(bad),
        c(&["run_then"], "run then", None, |(_, line)| Value::of(line.run.then, Value::Real)),
        c(&["run_now", "run_low", "run_high"], "run now [95%]", Ratio, |(_, line)| {
            Value::of(line.run.now, Value::Measured)
        }).or(bad),
    ]
}

/// In the place of the times of a row that is not right.
fn bad((_, line): &SceneLine<'_>) -> Option<Cell> {
    let is_bad = line.verdict != RowVerdict::Ok;
    is_bad.then(|| Cell { text: line.verdict.name().into(), style: Style::Bad })
}

fn of_scene(comparison: &Comparison) -> impl Iterator<Item = SceneLine<'_>> {
    comparison.lines.iter().map(|line| (&*comparison.scene, line))
}

fn table(comparison: &Comparison) -> Table {
    let heads = ["lecture", "build then", "build now [95%]", "run then", "run now [95%]", "ours"];
    let correlation = |of: fn(&Line) -> Ratios| {
        comparison.correlation(of).map_or("-".to_owned(), |r| format!("{r:.2}"))
    };
    Table {
        title: format!("{}: times divided by those of uniform D=1", comparison.scene),
        notes: vec![format!(
            "Rank correlation of then and now: build {}, run {}.",
            correlation(|l| l.build),
            correlation(|l| l.run)
        )],
        ..column::table(&columns(), &heads, of_scene(comparison))
    }
}
