//! Tables of the other formats as HTML.

use crate::report::glossary::meaning;
use presentation::html::{Attribute, Html};
use presentation::table::{Cell, Style, Table};

/// How a table is written.
#[derive(Debug, Clone, Copy, Default)]
pub struct Look {
    /// Rows have their numbers before them.
    pub is_numbered: bool,
}

/// A table within a box of its own, so that it scrolls and not the page; its notes below.
pub fn write(html: &mut Html, table: &Table, look: Look) {
    let is_words: Vec<bool> = (0..table.header.len()).map(|i| is_words(table, i)).collect();
    let is_words = |column: usize| is_words.get(column) == Some(&true);
    html.open_scroll(&table.title);
    html.open("table", &[]);
    html.element("caption", &[], &table.title);
    html.open("thead", &[]);
    html.open("tr", &[]);
    if look.is_numbered {
        html.element("th", &[("scope", "col"), ("class", "number")], "#");
    }
    for (column, name) in table.header.iter().enumerate() {
        let class: &[Attribute<'_>] = if is_words(column) { &[("class", "words")] } else { &[] };
        html.open("th", &[&[("scope", "col")], class].concat());
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
            write_cell(html, column, cell, is_words(column));
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

/// The first column names the rows; of the others, those most of whose cells begin with a letter.
fn is_words(table: &Table, column: usize) -> bool {
    let begins_with_letter =
        |cell: &&Cell| cell.text.trim().chars().next().is_some_and(char::is_alphabetic);
    // cells that say that something is wrong stand among numbers
    let cells =
        || table.rows.iter().filter_map(|r| r.get(column)).filter(|c| c.style != Style::Bad);
    column == 0 || 2 * cells().filter(begins_with_letter).count() > cells().count()
}

fn write_cell(html: &mut Html, column: usize, cell: &Cell, is_words: bool) {
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
        0 => html.element("th", &[&[("scope", "row")], class].concat(), cell.text.trim()),
        _ => html.element("td", class, cell.text.trim()),
    }
}

/// A table of texts.
pub fn words(title: String, header: Vec<&'static str>, rows: Vec<Vec<String>>) -> Table {
    let rows = rows.into_iter().map(|row| row.into_iter().map(Cell::from).collect()).collect();
    Table { title, header, rows, notes: Vec::new() }
}
