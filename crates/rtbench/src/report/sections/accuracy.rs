//! What accuracy costs in time: each axis with its front.

use crate::report::glossary::look;
use crate::report::material::Material;
use crate::report::page::{Page, SectionOutcome};
use presentation::page::tables;
use studies::accuracy::{plot, summary, tables as axis_tables};

/// Axis by axis: in words, as a plot, as tables.
pub fn write(material: &Material, page: &mut Page) -> SectionOutcome {
    let Some(run) = &material.accuracy else { return SectionOutcome::Missing };
    page.html.list(axis_tables::facts(run));
    for axis in &run.axes {
        page.html.element("h3", &[], &axis.axis);
        let mut in_words: Vec<String> = Vec::new();
        if let Some(cost) = summary::cost(axis, run.seed) {
            let line = summary::line(axis, &cost);
            let (first, scenes) = line.split_once(". ").unwrap_or((&line, ""));
            page.html.paragraph(&format!("{}.", first.trim_end_matches('.')));
            in_words = scenes.split("; ").map(str::to_owned).collect();
        }
        for scene in &axis.scenes {
            let name = format!("accuracy-{}-{}", axis.axis, scene.scene);
            page.plot(&name, plot::panel(axis, scene));
        }
        page.html.open("details", &[]);
        page.html.element("summary", &[], &format!("{}: scene by scene", axis.axis));
        page.html.list(in_words.into_iter().filter(|line| !line.is_empty()));
        for scene in &axis.scenes {
            tables::write(&mut page.html, &axis_tables::table(axis, scene), look());
        }
        page.html.close();
    }
    page.html.list(axis_tables::GLOSSARY.iter().map(|line| (*line).to_owned()));
    SectionOutcome::Yes
}
