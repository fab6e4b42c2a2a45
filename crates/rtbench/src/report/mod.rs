//! The results in a folder, or in several, as an HTML report: no network, no font of others.
//!
//! A section is a function and a line in [`SECTIONS`]. One that the folder has nothing for is left
//! out; the end of the page names the command that makes it.

pub mod material;
pub mod page;
mod plots;
mod sections;

pub use material::ReportError;
pub use page::{Page, file_name};

use crate::report::material::Material;
use measurement::system::progress::Progress;
use presentation::html::Html;
use presentation::page::{BEGINNING, finished, start_page};
use studies::run::few::Few;

pub struct Section {
    pub id: &'static str,
    pub title: &'static str,
    /// The command that makes what it shows; `DIR` is the folder.
    pub made_by: &'static str,
    /// Writes it, or nothing where the folder has nothing for it.
    pub write: fn(&Material, &mut Page),
}

/// Command that creates the data of the sections that every page has.
const BY_RUN: &str = "rtbench run -o DIR";

/// All parts, in their order on the page.
#[rustfmt::skip]
pub static SECTIONS: &[Section] = &[
    section("headlines", "Answers", BY_RUN, sections::run::headlines),
    section("all-scenes", "All scenes together", BY_RUN, sections::run::summary),
    section("scenes", "Each scene", BY_RUN, sections::run::scenes),
    section("heat-maps", "Where the work is in the image", "rtbench cost SCENE --heat-maps DIR/heat-maps/SCENE", sections::studies::heat_maps),
    section("by-kind", "Each kind of ray", BY_RUN, sections::run::by_kind),
    section("break-even", "Fastest structure by number of rays", BY_RUN, sections::break_even::write),
    section("counters", "Counters of 1999 against now", "rtbench reproduce havran1999 -o DIR", sections::studies::counters),
    section("lecture", "Zachmann 2007 against now", "rtbench reproduce zachmann2007 -o DIR", sections::studies::lecture),
    section("accuracy", "What accuracy costs in time", "rtbench accuracy -o DIR/accuracy", sections::studies::accuracy),
    section("tracers", "Samples, cones and beams", "rtbench compare-tracers SCENE -o DIR/tracers/SCENE", sections::studies::tracers),
    section("sweeps", "Parameters over their values", "rtbench sweep SCENE -s STRUCTURE -p PARAM --values A..B -o DIR/sweep-PARAM", sections::studies::sweeps),
    section("warnings", "Warnings and outliers", BY_RUN, sections::machine::write_warnings),
    section("machine", "How to repeat it", BY_RUN, sections::machine::write),
    section("glossary", "What the symbols mean", BY_RUN, page::glossary),
];

const fn section(
    id: &'static str,
    title: &'static str,
    made_by: &'static str,
    write: fn(&Material, &mut Page),
) -> Section {
    Section { id, title, made_by, write }
}

/// Section that appears once on a page of several runs.
const ONCE: &str = "glossary";

pub struct FinishedPage {
    /// HTML that is well-formed XML, too.
    pub html: String,
    /// Its plots: file names and SVG.
    pub plots: Vec<(String, String)>,
}

/// Returns whether a file's beginning is that of such a page.
pub fn is_page(beginning: &str) -> bool {
    beginning.starts_with(BEGINNING) && beginning.contains("<title>rtbench: ")
}

/// A section that has something to show.
struct ReportSection {
    id: String,
    title: &'static str,
    /// Contents below its head.
    body: String,
}

/// The page of all that the folders have. Where it lies beside the only record it links to it.
pub fn page(runs: &[Material], is_beside_record: bool, progress: Progress) -> FinishedPage {
    let mut page = Page { is_beside_record, progress, ..Page::default() };
    let title = format!("rtbench: {}", title(runs));
    let mut html = start_page(&title);
    html.open("header", &[]);
    html.element("h1", &[], &title);
    match runs {
        [run] => {
            sections::machine::one_line(run, &mut html);
            let parts = parts(run, &mut page, |_| true);
            nav(&mut html, parts.iter().map(|part| (part.id.as_str(), part.title)));
            html.close();
            html.open("main", &[("id", "main")]);
            parts.iter().for_each(|part| write(&mut html, part));
            missing(&mut html, &parts, &page);
        }
        _ => several(&mut html, &mut page, runs),
    }
    let Page { plots, progress, .. } = page;
    progress.finish();
    let html = finished(html);
    let few = if let [run] = runs { Few::of(&run.run) } else { None };
    FinishedPage { html: few.map_or_else(|| html.clone(), |few| few.page(&html)), plots }
}

/// Answers of all runs, the runs side by side, and each by itself in a part that is folded.
fn several(html: &mut Html, page: &mut Page, runs: &[Material]) {
    let part = |id: &str, title, body| ReportSection { id: id.to_owned(), title, body };
    sections::run::answers(runs, page);
    let answers = part("headlines", "Answers", page.take());
    sections::run::side_by_side(runs, page);
    let top = [answers, part("side-by-side", "Side by side", page.take())];
    let names: Vec<(String, String)> = (1..)
        .zip(runs)
        .map(|(n, run)| (format!("run-{n}"), format!("Run {n}: {}", run.in_words())))
        .collect();
    let links = top.iter().map(|part| (part.id.as_str(), part.title));
    let names_of_runs = names.iter().map(|(id, name)| (id.as_str(), name.as_str()));
    nav(html, links.chain(names_of_runs).chain([(ONCE, "What the symbols mean")]));
    html.close();
    html.open("main", &[("id", "main")]);
    top.iter().for_each(|part| write(html, part));
    for (run, (id, name)) in runs.iter().zip(&names) {
        page.prefix = format!("{id}-");
        let parts = parts(run, page, |id| id != ONCE);
        html.open_details(&[("id", id), ("class", "run")], name);
        sections::machine::one_line(run, html);
        nav(html, parts.iter().map(|part| (part.id.as_str(), part.title)));
        parts.iter().for_each(|part| write(html, part));
        missing(html, &parts, page);
        html.close();
    }
    page.prefix = String::new();
    if let Some(run) = runs.first() {
        parts(run, page, |id| id == ONCE).iter().for_each(|part| write(html, part));
    }
}

/// The sections that have something to show of a run.
fn parts(run: &Material, page: &mut Page, is_wanted: impl Fn(&str) -> bool) -> Vec<ReportSection> {
    let mut parts = Vec::new();
    for section in SECTIONS.iter().filter(|section| is_wanted(section.id)) {
        (section.write)(run, page);
        let body = page.take();
        if !body.is_empty() {
            parts.push(ReportSection { id: page.anchor(section.id), title: section.title, body });
        }
    }
    parts
}

fn write(html: &mut Html, ReportSection { id, title, body }: &ReportSection) {
    html.open_section(id, title);
    html.markup(body);
    html.close();
}

fn nav<'a>(html: &mut Html, links: impl Iterator<Item = (&'a str, &'a str)>) {
    html.open("nav", &[("aria-label", "sections")]);
    // on a phone they would stand where the answers are looked for
    html.open_details(&[], "Contents");
    html.items(&[], links, |html, (id, title)| {
        html.element("a", &[("href", &format!("#{id}"))], title);
    });
    html.close();
    html.close();
}

/// Lists missing sections with the commands that create them: folded, at the end.
fn missing(html: &mut Html, parts: &[ReportSection], page: &Page) {
    let is_there = |id: &str| parts.iter().any(|part| part.id == page.anchor(id));
    let missing: Vec<&Section> =
        SECTIONS.iter().filter(|s| s.made_by != BY_RUN && !is_there(s.id)).collect();
    if missing.is_empty() {
        return;
    }
    let summary = "Other results that this page can show, and the commands for them";
    html.open_details(&[("class", "more")], summary);
    html.items(&[], missing, |html, section| {
        html.text(&format!("{}: ", section.title));
        html.element("code", &[], section.made_by);
    });
    html.close();
}

fn title(runs: &[Material]) -> String {
    match runs {
        [Material { run, .. }] if run.scenes.len() > 3 => format!("{} scenes", run.scenes.len()),
        [Material { run, .. }] if run.scenes.is_empty() => "no finished scene".to_owned(),
        [Material { run, .. }] => {
            run.scenes.iter().map(|scene| &*scene.name).collect::<Vec<_>>().join(", ")
        }
        _ => format!("{} runs side by side", runs.len()),
    }
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
