//! Sections of the run itself: the answers, all scenes, kinds of rays, each scene.

use crate::report::glossary::{look, numbered};
use crate::report::material::Material;
use crate::report::page::{Page, SectionOutcome};
use crate::report::plots;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use measurement::record::{SceneRecord, Verdict};
use presentation::html::Html;
use presentation::page::tables;
use presentation::table::Table;
use studies::run::lines::{self, Line, Lines, names};
use studies::run::tables::{scene_table, summary_table};
use studies::run::view::{View, by_weight};
use studies::run::{columns, kind_tables};

/// Over all scenes; those of each stand with it.
pub fn headlines(material: &Material, page: &mut Page) -> SectionOutcome {
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
    SectionOutcome::Yes
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
pub fn summary(material: &Material, page: &mut Page) -> SectionOutcome {
    let run = &material.run;
    // of a single scene they are its own ratios
    if run.summary.is_empty() || run.scenes.len() < 2 {
        return SectionOutcome::Missing;
    }
    page.plot("all-scenes", plots::summary_bars(run));
    let rows = View::fastest_first().summary(&run.summary);
    let table = summary_table(run, rows.iter().copied(), false);
    let numbers = crate::report::sections::places(&run.summary, &rows);
    tables::write(&mut page.html, &table, numbered(&numbers));
    SectionOutcome::Yes
}

/// Missing of records from before there were ratios by kind.
pub fn by_kind(material: &Material, page: &mut Page) -> SectionOutcome {
    let run = &material.run;
    let rows = || run.scenes.iter().flat_map(|scene| &scene.rows);
    if rows().all(|row| row.ratio_by_kind.is_empty()) {
        return SectionOutcome::Missing;
    }
    let of = |table: &Table, page: &mut Page| tables::write(&mut page.html, table, look());
    of(&kind_tables::picture_table(run), page);
    if run.scenes.len() > 1 {
        of(&kind_tables::summary_table(run, false), page);
    }
    let view = View::fastest_first();
    for scene in &run.scenes {
        of(&kind_tables::scene_table(run, scene, view.rows(&scene.rows), false), page);
    }
    SectionOutcome::Yes
}

pub fn scenes(material: &Material, page: &mut Page) -> SectionOutcome {
    let run = &material.run;
    if run.scenes.is_empty() {
        return SectionOutcome::Missing;
    }
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
        page.plot(&format!("bars-{}", scene.name), plots::scene_bars(run, scene));
        let rows = View::fastest_first().rows(&scene.rows);
        let table = by_weight(&scene_table(run, scene, rows.iter().copied(), false));
        let numbers = crate::report::sections::places(&scene.rows, &rows);
        tables::write(&mut page.html, &table, numbered(&numbers));
        if let Some(table) = columns::foreign_table(scene) {
            tables::write(&mut page.html, &table, numbered(&[]));
        }
    }
    SectionOutcome::Yes
}

fn picture(html: &mut Html, scene: &SceneRecord, png: &[u8]) {
    let source = format!("data:image/png;base64,{}", STANDARD.encode(png));
    let text = format!("the scene {}", scene.name);
    html.open("figure", &[("class", "picture scene")]);
    html.void("img", &[("src", &source), ("alt", &text), ("width", "256"), ("height", "256")]);
    html.element("figcaption", &[], &format!("{}: {} primitives", scene.name, scene.primitives));
    html.close();
}
