//! What accuracy costs in time: each axis with its front.

use crate::report::material::Material;
use crate::report::page::{Page, Shown};
use crate::report::tables::{self, Look};
use presentation::svg_plot::figure;
use studies::accuracy::{plot, summary, tables as axis_tables};

/// Axis by axis: in words, as a plot, as tables.
pub fn write(material: &Material, page: &mut Page) -> Shown {
    let Some(run) = &material.accuracy else { return Shown::Missing };
    page.html.list(axis_tables::facts(run));
    for axis in &run.axes {
        page.html.element("h3", &[], &axis.axis);
        if let Some(cost) = summary::cost(axis, run.seed) {
            page.html.paragraph(&summary::line(axis, &cost));
        }
        for scene in &axis.scenes {
            let name = format!("accuracy-{}-{}", axis.axis, scene.scene);
            page.plot(&name, figure(&[plot::panel(axis, scene)]));
        }
        page.html.open("details", &[]);
        page.html.element("summary", &[], &format!("{}: all variants", axis.axis));
        for scene in &axis.scenes {
            tables::write(&mut page.html, &axis_tables::table(axis, scene), Look::default());
        }
        page.html.close();
    }
    page.html.list(axis_tables::GLOSSARY.iter().map(|line| (*line).to_owned()));
    Shown::Yes
}
