//! Each scene: its picture, its answers, its bars, and its table in the manner of Havran and Sixta
//! (1999).

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

use crate::report::glossary::numbered;
use crate::report::material::Material;
use crate::report::page::{Page, SectionOutcome};
use crate::report::plots;
use measurement::record::SceneRecord;
use presentation::html::Html;
use presentation::page::tables;
use studies::run::foreign;
use studies::run::lines;
use studies::run::tables::scene_table_of;
use studies::run::view::{View, by_weight};

pub fn write(material: &Material, page: &mut Page) -> SectionOutcome {
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
            super::headlines::list(&mut page.html, &lines::of_scene(scene));
        }
        page.plot(&format!("bars-{}", scene.name), plots::scene_bars(run, scene));
        let rows = View::fastest_first().rows(&scene.rows);
        let table = by_weight(&scene_table_of(run, scene, &rows, false));
        let numbers = super::places(&scene.rows, &rows);
        tables::write(&mut page.html, &table, numbered(&numbers));
        if let Some(table) = foreign::table(scene) {
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
