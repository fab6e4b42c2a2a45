//! All scenes together: the bars and the table.

use crate::report::glossary::numbered;
use crate::report::material::Material;
use crate::report::page::{Page, SectionOutcome};
use crate::report::plots;
use presentation::page::tables;
use studies::run::tables::summary_table_of;
use studies::run::view::View;

/// The geometric means, the fastest first.
pub fn write(material: &Material, page: &mut Page) -> SectionOutcome {
    let run = &material.run;
    // of a single scene they are its own ratios
    if run.summary.is_empty() || run.scenes.len() < 2 {
        return SectionOutcome::Missing;
    }
    page.plot("all-scenes", plots::summary_bars(run));
    let rows = View::fastest_first().summary(&run.summary);
    let table = summary_table_of(run, &rows, false);
    let numbers = super::places(&run.summary, &rows);
    tables::write(&mut page.html, &table, numbered(&numbers));
    SectionOutcome::Yes
}
