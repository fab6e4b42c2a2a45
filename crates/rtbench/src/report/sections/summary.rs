//! All scenes together: the table and the bars.

use crate::report::material::Material;
use crate::report::page::{Page, Shown};
use crate::report::plots;
use crate::report::tables::{self, Look};
use studies::run::tables::summary_table;

/// The geometric means.
pub fn write(material: &Material, page: &mut Page) -> Shown {
    if material.run.summary.is_empty() {
        return Shown::Missing;
    }
    page.plot("all-scenes", plots::summary_bars(&material.run));
    let look = Look { is_numbered: true };
    tables::write(&mut page.html, &summary_table(&material.run, false), look);
    Shown::Yes
}
