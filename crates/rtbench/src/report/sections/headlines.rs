//! Which row is the fastest at what, and how sure that is: what `run` ends with.

use crate::report::material::Material;
use crate::report::page::{Page, SectionOutcome};
use measurement::record::{SceneRecord, Verdict};
use presentation::html::Html;
use studies::run::lines::{self, Line, Lines, names};

/// Over all scenes; those of each stand with it.
pub fn write(material: &Material, page: &mut Page) -> SectionOutcome {
    let (run, html) = (&material.run, &mut page.html);
    if !run.complete {
        alert(
            html,
            &format!(
                "This run was not finished: {} of {} scenes. `rtbench run --resume DIR` measures the \
                 others.",
                run.scenes.len(),
                run.planned.len()
            ),
        );
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
        if let Some(text) = wrong_rows(scene) {
            alert(&mut page.html, &text);
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
    html.open("ul", &[("class", "headlines")]);
    for Line { head, text } in lines {
        html.open("li", &[]);
        html.element("strong", &[], head);
        html.text(&format!(": {text}"));
        html.close();
    }
    html.close();
}

fn alert(html: &mut Html, text: &str) {
    html.element("p", &[("class", "alert"), ("role", "note")], text);
}

fn wrong_rows(scene: &SceneRecord) -> Option<String> {
    let wrong = scene.rows.iter().filter(|row| row.verdict == Verdict::Wrong);
    let wrong: Vec<String> = wrong.map(|row| row.label()).collect();
    (!wrong.is_empty()).then(|| {
        format!("{}: {}. No times are shown of them.", scene.name, names("wrong hits of", &wrong))
    })
}
