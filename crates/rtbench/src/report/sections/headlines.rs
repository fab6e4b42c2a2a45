//! Which row is the fastest at what, and how sure that is: what `run` ends with.

use crate::report::material::Material;
use crate::report::page::{Page, Shown};
use measurement::record::{SceneRecord, Verdict};
use presentation::html::Html;
use studies::run::lines::{self, Line, Lines, names};

/// Over all scenes, then each.
pub fn write(material: &Material, page: &mut Page) -> Shown {
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
    let overall = lines::of_run(run).filter(|_| run.scenes.len() > 1);
    let scenes = run.scenes.iter().map(lines::of_scene);
    for lines in overall.into_iter().chain(scenes) {
        list(html, &lines);
    }
    html.paragraph(lines::NOTE);
    for scene in &run.scenes {
        if let Some(text) = wrong_rows(scene) {
            alert(html, &text);
        }
    }
    Shown::Yes
}

fn list(html: &mut Html, Lines { title, lines }: &Lines) {
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
