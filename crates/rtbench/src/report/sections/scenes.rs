//! Each scene: its table in the manner of Havran and Sixta (1999), and its bars.

use crate::report::material::Material;
use crate::report::page::{Page, Shown};
use crate::report::plots;
use crate::report::tables::{self, Look};
use studies::run::foreign;
use studies::run::tables::scene_table;

/// One after another.
pub fn write(material: &Material, page: &mut Page) -> Shown {
    if material.run.scenes.is_empty() {
        return Shown::Missing;
    }
    page.html.open("p", &[]);
    page.html.text("The heads of the columns are explained ");
    page.html.element("a", &[("href", "#glossary")], "at the end");
    page.html.text(".");
    page.html.close();
    for scene in &material.run.scenes {
        page.html.element("h3", &[], &scene.name);
        page.plot(&format!("bars-{}", scene.name), plots::scene_bars(&material.run, scene));
        let look = Look { is_numbered: true };
        tables::write(&mut page.html, &scene_table(&material.run, scene, false), look);
        if let Some(table) = foreign::table(scene) {
            tables::write(&mut page.html, &table, look);
        }
    }
    Shown::Yes
}
