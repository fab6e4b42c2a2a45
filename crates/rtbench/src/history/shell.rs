//! Parts shared by all pages of the site: head, navigation, and wording of changes.

use crate::history::lines::{Change, History, Line};
use crate::report::utc;
use presentation::html::Html;
use presentation::numbers::ratio;
use presentation::table::{Cell, Style};
use statistics::estimate::Estimate;

/// A page of that title, opened as far as its main part; links lead up.
pub fn start_page(title: &str, intro: &str, up: &[(&str, String)]) -> Html {
    let mut html = presentation::page::start_page(&format!("rtbench: {title}"));
    html.open("header", &[]);
    if !up.is_empty() {
        html.open("nav", &[("aria-label", "the way up")]);
        html.items(&[], up, |html, (name, path)| html.element("a", &[("href", path)], name));
        html.close();
    }
    html.element("h1", &[], title);
    html.paragraph(intro);
    html.close();
    html.open("main", &[("id", "main")]);
    html
}

/// A part of a page, opened.
pub fn section(html: &mut Html, id: &str, title: &str) {
    let heading = format!("{id}-title");
    html.open("section", &[("id", id), ("aria-labelledby", &heading)]);
    html.element("h2", &[("id", &heading)], title);
}

/// The path from a page one folder down.
pub fn from_below(path: &str) -> String {
    format!("../{path}")
}

pub fn verdict(times: &Estimate) -> &'static str {
    match times {
        t if t.low > 1.0 => "slower",
        t if t.high < 1.0 => "faster",
        _ => "changed",
    }
}

pub fn class_of(times: &Estimate) -> &'static str {
    match verdict(times) {
        "slower" => "bad",
        "faster" => "best",
        _ => "dim",
    }
}

pub fn change_cell(text: String, times: &Estimate) -> Cell {
    Cell { text, style: if times.low > 1.0 { Style::Bad } else { Style::Best } }
}

/// A machine among several, by its number from 1.
pub fn bench_name(bench: usize) -> String {
    format!("machine {}", bench + 1)
}

pub fn day(unix_s: u64) -> String {
    utc(unix_s).chars().take(10).collect()
}

/// A change in words: `at 8c1f2e (2026-11-20), after 77ab01: 1.20 [1.18, 1.22] times`.
pub fn in_words(history: &History, line: &Line, change: &Change) -> String {
    let of = |visit: usize| history.visits.get(visit);
    let Some([before, after]) = line.around(change) else { return String::new() };
    let (Some(before), Some(after)) = (of(before.visit), of(after.visit)) else {
        return String::new();
    };
    let mut text = format!(
        "at {} ({}), after {}: {} times",
        after.id(),
        day(after.unix_s()),
        before.id(),
        ratio(&change.times).trim_end()
    );
    if history.benches.len() > 1 {
        text += &format!(", on {}", bench_name(line.bench));
    }
    text
}
