//! Sections of the run itself: the answers, all scenes, kinds of rays, each scene; and several runs on
//! one page: what each answers, and the ratios of each row in all of them.
//!
//! A ratio is to the reference of its own run, so that runs of two machines can stand side by side,
//! and seconds cannot. What differs between two runs of a program, and how surely, says `rtbench
//! compare`.

use std::collections::BTreeSet;

use crate::comparison::pairing::row_like;
use crate::report::material::Material;
use crate::report::page::{Page, image};
use crate::report::plots;
use measurement::record::{RowRecord, SceneRecord, Verdict, reference};
use presentation::html::Html;
use presentation::numbers::ratio;
use presentation::svg_plot::Ring;
use presentation::svg_plot::bars::{BarChart, BarRow};
use presentation::table::{Cell, Style, Table, dash};
use studies::run::lines::{self, Line, Lines, names};
use studies::run::tables::{scene_table, summary_table};
use studies::run::view::{View, by_weight};
use studies::run::{columns, kind_tables};

/// Over all scenes; those of each stand with it.
pub fn headlines(material: &Material, page: &mut Page) {
    let (run, html) = (&material.run, &mut page.html);
    if !run.complete {
        let (finished, all) = (run.scenes.len(), run.planned.len());
        let text = format!(
            "This run was not finished: {finished} of {all} scenes. `rtbench run --resume DIR` \
             measures the others."
        );
        alert(html, &text);
    }
    if let Some(lines) = lines::of_run(run) {
        list(html, &lines);
    }
    html.element("p", &[("class", "notes")], lines::NOTE);
    if run.scenes.len() > 1 {
        let anchors: Vec<(String, &str)> = run
            .scenes
            .iter()
            .map(|scene| (page.anchor(&format!("scene-{}", scene.name)), scene.name.as_str()))
            .collect();
        links(&mut page.html, &anchors);
    }
    for scene in &run.scenes {
        let wrong = scene.rows.iter().filter(|row| row.verdict == Verdict::Wrong);
        let wrong: Vec<String> = wrong.map(|row| row.label()).collect();
        if !wrong.is_empty() {
            let wrong = names("wrong hits of", &wrong);
            alert(&mut page.html, &format!("{}: {wrong}. Their times are not shown.", scene.name));
        }
    }
}

/// To the answers of each scene.
fn links(html: &mut Html, scenes: &[(String, &str)]) {
    html.open("p", &[]);
    html.text("The answers of each scene: ");
    for (i, (anchor, name)) in scenes.iter().enumerate() {
        html.text(if i == 0 { "" } else { ", " });
        html.element("a", &[("href", &format!("#{anchor}"))], name);
    }
    html.text(".");
    html.close();
}

/// A question a line.
pub fn list(html: &mut Html, Lines { title, lines }: &Lines) {
    html.element("p", &[("class", "headline")], title);
    html.items(&[("class", "headlines")], lines, |html, Line { head, text }| {
        html.element("strong", &[], head);
        html.text(&format!(": {text}"));
    });
}

fn alert(html: &mut Html, text: &str) {
    html.element("p", &[("class", "alert"), ("role", "note")], text);
}

/// The geometric means, the fastest first.
pub fn summary(material: &Material, page: &mut Page) {
    let run = &material.run;
    // of a single scene they are its own ratios
    if run.summary.is_empty() || run.scenes.len() < 2 {
        return;
    }
    page.plot("all-scenes", &plots::summary_bars(run));
    let rows = View::fastest_first().summary(&run.summary);
    let table = summary_table(run, rows.iter().copied(), false);
    let numbers = places(&run.summary, &rows);
    page.numbered_table(&table, &numbers);
}

/// The places of rows among all, from 1: their numbers, however they are sorted.
fn places<R>(all: &[R], shown: &[&R]) -> Vec<usize> {
    let place = |row: &&R| all.iter().position(|other| std::ptr::eq(other, *row));
    shown.iter().map(|row| place(row).map_or(0, |place| place + 1)).collect()
}

/// Missing of records from before there were ratios by kind.
pub fn by_kind(material: &Material, page: &mut Page) {
    let run = &material.run;
    let rows = || run.scenes.iter().flat_map(|scene| &scene.rows);
    if rows().all(|row| row.ratio_by_kind.is_empty()) {
        return;
    }
    page.table(&kind_tables::picture_table(run));
    if run.scenes.len() > 1 {
        page.table(&kind_tables::summary_table(run, false));
    }
    let view = View::fastest_first();
    for scene in &run.scenes {
        page.table(&kind_tables::scene_table(run, scene, view.rows(&scene.rows), false));
    }
}

pub fn scenes(material: &Material, page: &mut Page) {
    let run = &material.run;
    for scene in &run.scenes {
        let anchor = page.anchor(&format!("scene-{}", scene.name));
        page.html.element("h3", &[("id", &anchor)], &scene.name);
        if let Some(png) = material.pictures.get(&scene.name) {
            picture(&mut page.html, scene, png);
        }
        // those of the only scene stand above
        if run.scenes.len() > 1 {
            list(&mut page.html, &lines::of_scene(scene));
        }
        page.plot(&format!("bars-{}", scene.name), &plots::scene_bars(run, scene));
        let rows = View::fastest_first().rows(&scene.rows);
        let table = by_weight(&scene_table(run, scene, rows.iter().copied(), false));
        let numbers = places(&scene.rows, &rows);
        page.numbered_table(&table, &numbers);
        if let Some(table) = columns::foreign_table(scene) {
            page.table(&table);
        }
    }
}

fn picture(html: &mut Html, scene: &SceneRecord, png: &[u8]) {
    html.open("figure", &[("class", "picture scene")]);
    let text = format!("the scene {}", scene.name);
    image(html, "png", png, &text, &[("width", "256"), ("height", "256")]);
    html.element("figcaption", &[], &format!("{}: {} primitives", scene.name, scene.primitives));
    html.close();
}

/// Rows whose bars are drawn: the fastest of the first run.
const DRAWN: usize = 12;
/// Heads of the runs' columns; more runs are drawn alone.
const NUMBERS: [&str; 12] = [
    "run 1", "run 2", "run 3", "run 4", "run 5", "run 6", "run 7", "run 8", "run 9", "run 10",
    "run 11", "run 12",
];

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
pub fn side_by_side(runs: &[Material], page: &mut Page) {
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
        page.plot(&format!("side-by-side-{}", scene.name), &chart(&scene.name, &rows, &of));
        page.table(&table(&rows, &of));
    }
    if seen.is_empty() {
        page.html.paragraph("No two of these runs have a scene in common.");
    }
}

fn same<'r>(run: &'r Material, scene: &SceneRecord) -> Option<&'r SceneRecord> {
    run.run.scenes.iter().find(|own| own.name == scene.name && own.sha256 == scene.sha256)
}

fn in_runs<'r>(row: &RowRecord, of: &[Option<&'r SceneRecord>]) -> Vec<Option<&'r RowRecord>> {
    let find = |scene: &Option<&'r SceneRecord>| row_like((*scene)?, row);
    of.iter().map(find).collect()
}

fn chart(scene: &str, rows: &[&RowRecord], of: &[Option<&SceneRecord>]) -> BarChart {
    let drawn = rows.iter().take(DRAWN).flat_map(|row| {
        let own = in_runs(row, of).into_iter().enumerate();
        own.filter_map(|(run, own)| Some((run, own?))).enumerate().map(|(i, (run, own))| BarRow {
            name: match i {
                0 => format!("{} - run {}", row.label_with_query(), run + 1),
                _ => format!("run {}", run + 1),
            },
            color: run,
            bars: vec![plots::bar(own.verdict, own.ratio, |_| Ring::None)],
        })
    });
    BarChart {
        title: format!("{scene}: trace time over the reference's, run by run"),
        subtitle: format!("medians with 95% intervals; the {DRAWN} fastest rows of the first run"),
        columns: vec!["trace time, ratio".to_owned()],
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
