//! Parts shared by all pages of the site: head, navigation, wording of changes, and the files of the
//! site, by which pages link to one another.

use std::collections::{BTreeMap, BTreeSet};

use crate::history::lines::{Change, History, Key, Line, Quantity};
use crate::report::file_name;
use presentation::html::Html;
use presentation::numbers::{ratio, utc};
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

/// The page that all others are found from.
pub const INDEX: &str = "index.html";

/// Key of a page: scene, structure, quantity.
pub type PageKey = (String, String, Quantity);

/// The paths of all pages, from the site's folder on.
pub struct Names {
    pub scenes: BTreeMap<String, String>,
    /// Of structures within scenes.
    pub pages: BTreeMap<PageKey, String>,
}

pub fn page_of(key: &Key) -> PageKey {
    (key.scene.clone(), key.structure.clone(), key.quantity)
}

/// The part of its page that a row has.
pub fn anchor(settings: &str) -> String {
    match settings {
        "" => "defaults".to_owned(),
        settings => file_name(settings),
    }
}

impl Names {
    /// Names that are safe as files' and distinct, in upper and lower case alike.
    pub fn new(history: &History) -> Self {
        let mut taken = BTreeSet::from([INDEX.to_owned()]);
        let mut distinct = |stem: String| {
            let tries = std::iter::once(stem.clone()).chain((2..).map(|n| format!("{stem}-{n}")));
            let mut free = tries.filter(|path| taken.insert(path.to_lowercase()));
            free.next().unwrap_or(stem)
        };
        let (mut scenes, mut pages) = (BTreeMap::new(), BTreeMap::new());
        for key in history.lines.keys() {
            let folder = scenes.entry(key.scene.clone());
            let folder = folder.or_insert_with(|| distinct(file_name(&key.scene)));
            pages.entry(page_of(key)).or_insert_with(|| {
                let [kind, row] = [key.quantity.head(), &key.structure].map(file_name);
                distinct(format!("{folder}/{row}-{kind}")) + ".html"
            });
        }
        let scenes = scenes.into_iter().map(|(scene, folder)| (scene, format!("{folder}/{INDEX}")));
        Self { scenes: scenes.collect(), pages }
    }

    /// The page of a scene, from the site's folder on.
    pub fn scene(&self, scene: &str) -> &str {
        self.scenes.get(scene).map_or(INDEX, String::as_str)
    }

    /// The part of a page that a row has, from the site's folder on.
    pub fn row(&self, key: &Key) -> String {
        let page = self.pages.get(&page_of(key)).map_or(INDEX, String::as_str);
        format!("{page}#{}", anchor(&key.settings))
    }
}
