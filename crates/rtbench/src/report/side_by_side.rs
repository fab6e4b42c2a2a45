//! Several runs on one page: what each answers, and the ratios of each row in all of them.
//!
//! A ratio is to the reference of its own run, so that runs of two machines can stand side by side,
//! and seconds cannot. What differs between two runs of a program, and how surely, says `rtbench
//! compare`.

use std::collections::BTreeSet;

use crate::comparison::pairing::row_like;
use crate::report::glossary::look;
use crate::report::material::Material;
use crate::report::page::Page;
use crate::report::sections::run::list;
use measurement::record::{RowRecord, SceneRecord, reference};
use presentation::numbers::{ratio, short};
use presentation::page::tables;
use presentation::svg_plot::bars::{Bar, BarChart, BarRow, Column};
use presentation::svg_plot::{Axis, Ring, Scale};
use presentation::table::{Cell, Style, Table, dash};
use studies::run::lines;
use studies::run::view::View;

/// Rows whose bars are drawn: the fastest of the first run.
const DRAWN: usize = 12;
/// Heads of the runs' columns; more runs are drawn alone.
const NUMBERS: [&str; 12] = [
    "run 1", "run 2", "run 3", "run 4", "run 5", "run 6", "run 7", "run 8", "run 9", "run 10",
    "run 11", "run 12",
];

/// Conclusions of each run.
pub fn answers(runs: &[Material], page: &mut Page) {
    for (number, run) in (1..).zip(runs) {
        let html = &mut page.html;
        html.element("h3", &[], &format!("Run {number}: {}", run.in_words()));
        if let Some(lines) = lines::of_run(&run.run) {
            list(html, &lines);
        }
    }
    page.html.element("p", &[("class", "notes")], lines::NOTE);
}

/// Scene by scene, each that two runs have.
pub fn write(runs: &[Material], page: &mut Page) {
    page.html.paragraph(
        "Trace time over that of the reference in the same run, with its 95% interval: below 1 is faster than the \
         reference there. Runs of other machines or commits can be compared by it; `rtbench \
         compare` shows which differences of two runs are significant.",
    );
    let mut seen = BTreeSet::new();
    for scene in runs.iter().flat_map(|run| &run.run.scenes) {
        let of: Vec<Option<&SceneRecord>> = runs.iter().map(|run| same(run, scene)).collect();
        if of.iter().flatten().count() < 2 || !seen.insert((&scene.name, &scene.sha256)) {
            continue;
        }
        page.html.element("h3", &[], &scene.name);
        let view = View::fastest_first();
        let rows = view.rows(&scene.rows);
        page.plot(&format!("side-by-side-{}", scene.name), chart(&scene.name, &rows, &of));
        tables::write(&mut page.html, &table(&rows, &of), look());
    }
    if seen.is_empty() {
        page.html.paragraph("No two of these runs have a scene in common.");
    }
}

/// The very same scene in a run.
fn same<'r>(run: &'r Material, scene: &SceneRecord) -> Option<&'r SceneRecord> {
    run.run.scenes.iter().find(|own| own.name == scene.name && own.sha256 == scene.sha256)
}

/// The same row in each run.
fn in_runs<'r>(row: &RowRecord, of: &[Option<&'r SceneRecord>]) -> Vec<Option<&'r RowRecord>> {
    let find = |scene: &Option<&'r SceneRecord>| row_like((*scene)?, row);
    of.iter().map(find).collect()
}

fn chart(scene: &str, rows: &[&RowRecord], of: &[Option<&SceneRecord>]) -> BarChart {
    let bar = |row: &RowRecord| match row.ratio {
        _ if !row.verdict.is_timed() => Bar::Words(row.verdict.name().to_owned()),
        Some(e) => Bar::Of(e, short(e.median), Ring::None),
        None => Bar::Words("-".to_owned()),
    };
    let drawn = rows.iter().take(DRAWN).flat_map(|row| {
        let own = in_runs(row, of).into_iter().enumerate();
        own.filter_map(|(run, own)| Some((run, own?))).enumerate().map(|(i, (run, own))| BarRow {
            name: match i {
                0 => format!("{} - run {}", row.label_with_query(), run + 1),
                _ => format!("run {}", run + 1),
            },
            color: run,
            bars: vec![bar(own)],
        })
    });
    BarChart {
        title: format!("{scene}: trace time over the reference's, run by run"),
        subtitle: format!("medians with 95% intervals; the {DRAWN} fastest rows of the first run"),
        columns: vec![Column {
            axis: Axis { label: "trace time, ratio".to_owned(), scale: Scale::Log },
            base: 1.0,
        }],
        rows: drawn.collect(),
    }
}

fn table(rows: &[&RowRecord], of: &[Option<&SceneRecord>]) -> Table {
    let cell = |row: Option<&RowRecord>| match row {
        Some(row) if !row.verdict.is_timed() => {
            Cell { text: row.verdict.name().into(), style: Style::Bad }
        }
        Some(RowRecord { ratio: Some(e), .. }) => ratio(e).into(),
        _ => dash(),
    };
    let lines = rows.iter().map(|row| {
        let name = Cell::from(row.label_with_query());
        let own = in_runs(row, of).into_iter().take(NUMBERS.len()).map(cell);
        std::iter::once(name).chain(own).collect()
    });
    let references = (1..).zip(of).filter_map(|(number, scene)| {
        Some(format!("run {number}: {}", reference::of_scene((*scene)?)?))
    });
    Table {
        title: "trace ratio [95%] in each run".to_owned(),
        header: std::iter::once("structure").chain(NUMBERS.into_iter().take(of.len())).collect(),
        rows: lines.collect(),
        notes: vec![format!("References: {}.", references.collect::<Vec<_>>().join("; "))],
    }
}
