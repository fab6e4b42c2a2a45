//! Each kind of ray by itself, all scenes first, and the time to a picture.

use crate::report::material::Material;
use crate::report::page::{Page, Shown};
use crate::report::tables::{self, Look};
use studies::run::kind_tables;

/// Missing of records from before there were ratios by kind.
pub fn write(material: &Material, page: &mut Page) -> Shown {
    let run = &material.run;
    let rows = || run.scenes.iter().flat_map(|scene| &scene.rows);
    if rows().all(|row| row.ratio_by_kind.is_empty()) {
        return Shown::Missing;
    }
    let look = Look { is_numbered: true };
    tables::write(&mut page.html, &kind_tables::summary_table(run, false), look);
    tables::write(&mut page.html, &kind_tables::picture_table(run), Look::default());
    for scene in &run.scenes {
        page.html.element("h3", &[], &scene.name);
        tables::write(&mut page.html, &kind_tables::scene_table(run, scene, false), look);
    }
    Shown::Yes
}
