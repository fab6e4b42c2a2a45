//! Pages that need nothing but themselves: one file each, no network, no font of others. The only
//! script is ours, sorts and filters tables, and is let through by its hash; without it all is
//! there. Tables are those of the other formats.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use sha2::{Digest, Sha256};

use crate::html::{Attribute, Html};
use crate::svg_plot::pen::dark_rules;
use crate::svg_plot::{Figure, Format};
use crate::table::{Cell, Style, Table};

/// Style sheet of pages, except the colours of plots in dark mode.
static STYLE: &str = include_str!("page.css");
/// Sorts and filters tables.
static SCRIPT: &str = include_str!("page.js");

pub const BEGINNING: &str = "<!DOCTYPE html>\n";

/// A page of that title, opened as far as its body: what comes next is its header.
pub fn start_page(title: &str) -> Html {
    let mut html = Html::default();
    html.open("html", &[("lang", "en")]);
    html.open("head", &[]);
    html.void("meta", &[("charset", "utf-8")]);
    let viewport = "width=device-width, initial-scale=1";
    html.void("meta", &[("name", "viewport"), ("content", viewport)]);
    html.void("meta", &[("name", "color-scheme"), ("content", "light dark")]);
    // nothing may be loaded, and nothing but our script run, whatever a name or a message says
    let hash = STANDARD.encode(Sha256::digest(SCRIPT.as_bytes()));
    let policy = format!(
        "default-src 'none'; style-src 'unsafe-inline'; img-src data:; script-src 'sha256-{hash}'"
    );
    html.void("meta", &[("http-equiv", "Content-Security-Policy"), ("content", &policy)]);
    html.element("title", &[], title);
    html.markup(&format!(
        "<style>\n{STYLE}@media screen and (prefers-color-scheme: dark) {{\n{}}}\n</style>\n",
        dark_rules("figure svg")
    ));
    html.close();
    html.open("body", &[]);
    html.element("a", &[("class", "skip"), ("href", "#main")], "To the results");
    html
}

/// The whole text, all elements closed.
pub fn finished(mut html: Html) -> String {
    // the body, and all around it, stay open for the script
    html.close_until(2);
    html.markup(&format!("<script>{SCRIPT}</script>\n"));
    format!("{BEGINNING}{}", html.finish())
}

/// A drawing as wide windows show it, and as narrow ones do; returns the former.
pub fn figure(html: &mut Html, label: &str, drawing: &dyn Figure) -> String {
    html.open("figure", &[("aria-label", label)]);
    let wide = drawing.svg(Format::Wide);
    for (class, svg) in [("wide", &wide), ("narrow", &drawing.svg(Format::Narrow))] {
        html.open("div", &[("class", class)]);
        html.markup(svg);
        html.close();
    }
    html.close();
    wide
}

/// Tables of more rows are folded: a click opens them, and printing does.
const LONGEST: usize = 12;

#[derive(Debug, Clone, Copy, Default)]
pub struct TableStyle<'a> {
    /// The numbers of its rows, in a column before them; empty where they have none.
    pub numbers: &'a [usize],
    /// Link targets of cells, row by row; empty for no link.
    pub links: &'a [Vec<String>],
    pub ids: &'a [String],
    /// It is not folded, however long it is.
    pub is_open: bool,
    /// Explanation of a column's head, if needed.
    pub meaning: Option<fn(&str) -> Option<&'static str>>,
}

/// A table within a box of its own, so that it scrolls and not the page; its notes below. A long
/// one is folded.
pub fn write_table(html: &mut Html, table: &Table, look: TableStyle<'_>) {
    let is_long = table.rows.len() > LONGEST && !look.is_open;
    if is_long {
        let summary = format!("Table of {} rows: {}", table.rows.len(), table.title);
        html.open_details(&[], &summary);
    }
    html.open_scroll(&table.title);
    html.open("table", &[("class", "sorts")]);
    html.element("caption", &[], &table.title);
    let words: Vec<bool> = (0..table.header.len()).map(|i| is_words(table, i)).collect();
    let is_words = |column: usize| words.get(column) == Some(&true);
    heads(html, table, look, &is_words);
    html.open("tbody", &[]);
    for (i, row) in table.rows.iter().enumerate() {
        match look.ids.get(i) {
            Some(id) => html.open("tr", &[("id", id)]),
            None => html.open("tr", &[]),
        }
        let link = |column: usize| {
            let link = look.links.get(i).and_then(|row| row.get(column));
            link.map(String::as_str).filter(|link| !link.is_empty())
        };
        if !look.numbers.is_empty() {
            let number = look.numbers.get(i).map_or(String::new(), usize::to_string);
            html.element("td", &[("class", "number")], &number);
        }
        for (column, cell) in row.iter().enumerate() {
            write_cell(html, column, cell, is_words(column), link(column));
        }
        html.close();
    }
    html.close();
    html.close();
    html.close();
    if !table.notes.is_empty() {
        html.open("div", &[("class", "notes")]);
        html.list(table.notes.iter().cloned());
        html.close();
    }
    if is_long {
        html.close();
    }
}

fn heads(html: &mut Html, table: &Table, look: TableStyle<'_>, is_words: &dyn Fn(usize) -> bool) {
    html.open("thead", &[]);
    html.open("tr", &[]);
    if !look.numbers.is_empty() {
        html.element("th", &[("scope", "col"), ("class", "number")], "#");
    }
    for (column, name) in table.header.iter().enumerate() {
        let class: &[Attribute<'_>] = if is_words(column) { &[("class", "words")] } else { &[] };
        html.open("th", &[&[("scope", "col")], class].concat());
        match look.meaning.and_then(|meaning| meaning(name)) {
            Some(meaning) => html.element("abbr", &[("title", meaning)], name),
            None => html.text(name),
        }
        html.close();
    }
    html.close();
    html.close();
}

/// The first column names the rows; of the others, those most of whose cells begin with a letter.
fn is_words(table: &Table, column: usize) -> bool {
    let begins_with_letter =
        |cell: &&Cell| cell.text.trim().chars().next().is_some_and(char::is_alphabetic);
    // cells that say that something is wrong stand among numbers
    let cells =
        || table.rows.iter().filter_map(|r| r.get(column)).filter(|c| c.style != Style::Bad);
    column == 0 || 2 * cells().filter(begins_with_letter).count() > cells().count()
}

fn write_cell(html: &mut Html, column: usize, cell: &Cell, is_words: bool, link: Option<&str>) {
    let style = match cell.style {
        Style::Plain => "",
        Style::Bad => "bad",
        Style::Best => "best",
        Style::Dim => "dim",
    };
    let class = format!("{style} {}", if is_words { "words" } else { "" });
    let class: &[Attribute<'_>] = match class.trim() {
        "" => &[],
        class => &[("class", class)],
    };
    match column {
        0 => html.open("th", &[&[("scope", "row")], class].concat()),
        _ => html.open("td", class),
    }
    match link {
        Some(link) => html.element("a", &[("href", link)], cell.text.trim()),
        None => html.text(cell.text.trim()),
    }
    html.close();
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::table::words;

    #[test]
    fn the_only_script_is_the_one_whose_hash_the_policy_has() {
        let mut html = start_page("a < b");
        html.open("main", &[("id", "main")]);
        html.open("p", &[]);
        let page = finished(html);
        let options = roxmltree::ParsingOptions { allow_dtd: true, ..Default::default() };
        let tree = roxmltree::Document::parse_with_options(&page, options).expect("well-formed");
        let scripts: Vec<_> = tree.descendants().filter(|n| n.has_tag_name("script")).collect();
        assert_eq!(scripts.len(), 1);
        assert!(scripts[0].parent().unwrap().has_tag_name("body"), "behind all that was open");
        let hash = STANDARD.encode(Sha256::digest(scripts[0].text().unwrap().as_bytes()));
        let policy =
            tree.descendants().find_map(|n| n.attribute("content")?.contains("-src").then_some(n));
        let policy = policy.unwrap().attribute("content").unwrap();
        assert!(policy.ends_with(&format!("script-src 'sha256-{hash}'")), "{policy}");
        // read the same as HTML, which knows no escapes within scripts
        assert!(!SCRIPT.contains(['<', '&']) && !SCRIPT.contains("]]>"));
    }

    #[test]
    fn long_tables_are_folded_and_rows_keep_their_numbers() {
        let rows = |n: usize| (0..n).map(|i| vec![format!("row {i}"), "<1>".to_owned()]);
        let of = |n: usize, look| {
            let mut html = Html::default();
            write_table(&mut html, &words("t".to_owned(), vec!["name", "x"], rows(n)), look);
            html.finish()
        };
        let short = of(LONGEST, TableStyle::default());
        assert!(!short.contains("<details>") && short.contains("&lt;1&gt;"));
        let numbers: Vec<usize> = (0..=LONGEST).rev().collect();
        let meaning: fn(&str) -> _ = |head| (head == "x").then_some("what x means");
        let meaning = Some(meaning);
        let links = [vec![String::new(), "a.html#b".to_owned()]];
        let ids = ["first".to_owned()];
        let look =
            TableStyle { numbers: &numbers, links: &links, ids: &ids, is_open: false, meaning };
        let long = of(LONGEST + 1, look);
        assert!(long.starts_with("<details") && long.contains("Table of 13 rows: t"), "{long}");
        assert!(
            long.contains("<td class=\"number\">12</td><th scope=\"row\" class=\"words\">row 0")
        );
        assert!(long.contains("<abbr title=\"what x means\">x</abbr>"));
    }
}
