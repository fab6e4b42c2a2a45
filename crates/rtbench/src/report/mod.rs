//! The results in a folder as one page to read: no network, no script, no font of others.
//!
//! A section is a file and a line in [`SECTIONS`]. What the folder lacks is said, with the command
//! that makes it.

mod date;
mod glossary;
pub mod material;
pub mod page;
mod plots;
mod records;
mod sections;
mod tables;

pub use material::ReportError;
pub use page::{Page, Shown};

use crate::report::material::Material;
use measurement::system::progress::Progress;
use presentation::html::Html;
use presentation::svg_plot::palette::dark_rules;

/// How the page looks, but for the colours of plots in the dark.
static STYLE: &str = include_str!("page.css");

/// A part of the page.
pub struct Section {
    /// What links name it.
    pub id: &'static str,
    /// Its head.
    pub title: &'static str,
    /// The command that makes what it shows; `DIR` is the folder.
    pub made_by: &'static str,
    /// Writes it, or nothing where the folder has nothing for it.
    pub write: fn(&Material, &mut Page) -> Shown,
}

/// All parts, in their order on the page.
pub static SECTIONS: &[Section] = &[
    section("headlines", "In short", "rtbench run -o DIR", sections::headlines::write),
    section("all-scenes", "All scenes together", "rtbench run -o DIR", sections::summary::write),
    section("scenes", "Each scene", "rtbench run -o DIR", sections::scenes::write),
    section("by-kind", "Each kind of ray", "rtbench run -o DIR", sections::by_kind::write),
    section(
        "break-even",
        "Which structure wins for how many rays",
        "rtbench run -o DIR",
        sections::break_even::write,
    ),
    section(
        "counters",
        "Counters of 1999 against now",
        "rtbench reproduce havran1999 --export-csv DIR/havran1999.csv",
        sections::counters::write,
    ),
    section(
        "lecture",
        "Zachmann 2007 against now",
        "rtbench reproduce zachmann2007 --export-csv DIR/zachmann2007.csv",
        sections::lecture::write,
    ),
    section(
        "accuracy",
        "What accuracy costs in time",
        "rtbench accuracy -o DIR/accuracy",
        sections::accuracy::write,
    ),
    section(
        "tracers",
        "Samples, cones and beams",
        "rtbench compare-tracers SCENE -o DIR/tracers/SCENE",
        sections::tracers::write,
    ),
    section(
        "sweeps",
        "Parameters over their values",
        "rtbench sweep SCENE -s STRUCTURE -p PARAM --from A --to B --export-svg DIR/sweep-PARAM.svg",
        sections::sweeps::write,
    ),
    section(
        "heat-maps",
        "Where in the image the work is",
        "rtbench cost SCENE --heat-maps DIR/heat-maps/SCENE",
        sections::heat_maps::write,
    ),
    section("warnings", "Warnings and outliers", "rtbench run -o DIR", sections::warnings::write),
    section("machine", "How to repeat it", "rtbench run -o DIR", sections::machine::write),
    section("glossary", "What the symbols mean", "rtbench run -o DIR", sections::glossary::write),
];

const fn section(
    id: &'static str,
    title: &'static str,
    made_by: &'static str,
    write: fn(&Material, &mut Page) -> Shown,
) -> Section {
    Section { id, title, made_by, write }
}

/// A finished page.
pub struct Finished {
    /// HTML that is well-formed XML, too.
    pub html: String,
    /// Its plots: file names and SVG.
    pub plots: Vec<(String, String)>,
}

const BEGINNING: &str = "<!DOCTYPE html>\n";

/// Whether a file's beginning is that of such a page.
pub fn is_page(beginning: &str) -> bool {
    beginning.starts_with(BEGINNING) && beginning.contains("<title>rtbench: ")
}

/// The page of all sections. Where it lies beside the record it links to it.
pub fn page(material: &Material, is_beside_record: bool, progress: Progress) -> Finished {
    let mut page = Page { is_beside_record, progress, ..Page::default() };
    let title = format!("rtbench: {}", scenes_in_words(material));
    head(&mut page.html, &title);
    page.html.open("body", &[]);
    page.html.element("a", &[("class", "skip"), ("href", "#main")], "To the results");
    page.html.open("header", &[]);
    page.html.element("h1", &[], &title);
    sections::machine::one_line(material, &mut page.html);
    page.html.open("nav", &[("aria-label", "sections")]);
    page.html.open("ul", &[]);
    for section in SECTIONS {
        page.html.open("li", &[]);
        page.html.element("a", &[("href", &format!("#{}", section.id))], section.title);
        page.html.close();
    }
    page.html.close();
    page.html.close();
    page.html.close();
    page.html.open("main", &[("id", "main")]);
    for section in SECTIONS {
        let id = format!("{}-title", section.id);
        page.html.open("section", &[("id", section.id), ("aria-labelledby", &id)]);
        page.html.element("h2", &[("id", &id)], section.title);
        if (section.write)(material, &mut page) == Shown::Missing {
            page.html.open("p", &[("class", "missing")]);
            page.html.text("The folder has nothing of this. To add it: ");
            page.html.element("code", &[], section.made_by);
            page.html.close();
        }
        page.html.close();
    }
    let Page { html, plots, progress, .. } = page;
    progress.finish();
    Finished { html: format!("{BEGINNING}{}", html.finish()), plots }
}

fn scenes_in_words(material: &Material) -> String {
    let names: Vec<&str> = material.run.scenes.iter().map(|s| s.name.as_str()).collect();
    match &names[..] {
        [] => "no finished scene".to_owned(),
        few if few.len() <= 3 => few.join(", "),
        many => format!("{} scenes", many.len()),
    }
}

fn head(html: &mut Html, title: &str) {
    html.open("html", &[("lang", "en")]);
    html.open("head", &[]);
    html.void("meta", &[("charset", "utf-8")]);
    let viewport = "width=device-width, initial-scale=1";
    html.void("meta", &[("name", "viewport"), ("content", viewport)]);
    html.void("meta", &[("name", "color-scheme"), ("content", "light dark")]);
    // nothing may be loaded, whatever a name or a message says
    let policy = "default-src 'none'; style-src 'unsafe-inline'; img-src data:";
    html.void("meta", &[("http-equiv", "Content-Security-Policy"), ("content", policy)]);
    html.element("title", &[], title);
    html.markup(&format!(
        "<style>\n{STYLE}@media screen and (prefers-color-scheme: dark) {{\n{}}}\n</style>\n",
        dark_rules("figure svg")
    ));
    html.close();
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sections_have_names_of_their_own() {
        let mut ids: Vec<&str> = SECTIONS.iter().map(|s| s.id).collect();
        ids.sort_unstable();
        ids.dedup();
        assert_eq!(ids.len(), SECTIONS.len());
    }
}
