//! Tables of the other formats as HTML.

use crate::export::table::{Cell, Style, Table};
use crate::report::html::Html;
use crate::report::sections::glossary::meaning;

/// How a table is written.
#[derive(Debug, Clone, Copy, Default)]
pub struct Look {
    /// Rows have their numbers before them.
    pub is_numbered: bool,
    /// All columns are words.
    pub is_words: bool,
}

/// A table within a box of its own, so that it scrolls and not the page; its notes below.
pub fn write(html: &mut Html, table: &Table, look: Look) {
    let scroll = [("class", "scroll"), ("tabindex", "0"), ("role", "region")];
    html.open("div", &[&scroll[..], &[("aria-label", &table.title)]].concat());
    html.open("table", if look.is_words { &[("class", "words")] } else { &[] });
    html.element("caption", &[], &table.title);
    html.open("thead", &[]);
    html.open("tr", &[]);
    if look.is_numbered {
        html.element("th", &[("scope", "col"), ("class", "number")], "#");
    }
    for name in &table.header {
        html.open("th", &[("scope", "col")]);
        match meaning(name) {
            Some(meaning) => html.element("abbr", &[("title", meaning)], name),
            None => html.text(name),
        }
        html.close();
    }
    html.close();
    html.close();
    html.open("tbody", &[]);
    for (i, row) in table.rows.iter().enumerate() {
        html.open("tr", &[]);
        if look.is_numbered {
            html.element("td", &[("class", "number")], &(i + 1).to_string());
        }
        for (column, cell) in row.iter().enumerate() {
            write_cell(html, column, cell);
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
}

fn write_cell(html: &mut Html, column: usize, cell: &Cell) {
    let text = cell.text.trim();
    let class = match cell.style {
        Style::Plain => None,
        Style::Bad => Some(("class", "bad")),
        Style::Best => Some(("class", "best")),
        Style::Dim => Some(("class", "dim")),
    };
    if column == 0 {
        let attributes: Vec<_> = [("scope", "row")].into_iter().chain(class).collect();
        html.element("th", &attributes, text);
    } else {
        html.element("td", &class.into_iter().collect::<Vec<_>>(), text);
    }
}

/// A table of words, from texts.
pub fn words(title: String, header: Vec<&'static str>, rows: Vec<Vec<String>>) -> Table {
    let rows = rows.into_iter().map(|row| row.into_iter().map(Cell::from).collect()).collect();
    Table { title, header, rows, notes: Vec::new() }
}
