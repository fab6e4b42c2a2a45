//! Each kind of ray by itself, all scenes first, and the time to a picture.

use crate::report::glossary::look;
use crate::report::material::Material;
use crate::report::page::{Page, SectionOutcome};
use presentation::page::tables;
use presentation::table::Table;
use studies::run::kind_tables;
use studies::run::view::View;

/// Missing of records from before there were ratios by kind.
pub fn write(material: &Material, page: &mut Page) -> SectionOutcome {
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
        of(&kind_tables::scene_table_of(run, scene, &view.rows(&scene.rows), false), page);
    }
    SectionOutcome::Yes
}
