//! Tables for the terminal.

use std::io::{self, Write};

use crate::outside::{COLORS, line};
use crate::table::{Cell, Style, Table};

/// Prints lines of little weight.
///
/// # Errors
/// Those of the writer.
pub fn write_notes(out: &mut dyn Write, lines: &[&str], colors: bool) -> io::Result<()> {
    for line in lines {
        writeln!(out, "{}", painted(line, Style::Dim, colors))?;
    }
    Ok(())
}

/// Prints any table.
///
/// # Errors
/// Those of the writer.
pub fn write_table(out: &mut dyn Write, table: &Table, colors: bool) -> io::Result<()> {
    let table = &shown(table);
    let widths: Vec<usize> = (0..table.header.len())
        .map(|c| {
            let cells = table.rows.iter().filter_map(|r| r.get(c)).map(|c| c.text.chars().count());
            let title = table.header.get(c).map_or(0, |title| title.chars().count());
            cells.chain([title]).max().unwrap_or(0)
        })
        .collect();
    writeln!(out, "{}", painted(&table.title, Style::Best, colors))?;
    let header: Vec<Cell> = table.header.iter().map(|h| (*h).to_owned().into()).collect();
    for row in std::iter::once(&header).chain(&table.rows) {
        let last = row.len().saturating_sub(1);
        for (c, (cell, &width)) in row.iter().zip(&widths).enumerate() {
            // Names left, numbers right, the verdict left.
            let text = match c {
                0 => format!("{:<width$}", cell.text),
                _ if c == last => format!("  {}", cell.text),
                _ => format!("  {:>width$}", cell.text),
            };
            write!(out, "{}", painted(&text, cell.style, colors))?;
        }
        writeln!(out)?;
    }
    for note in &table.notes {
        writeln!(out, "{}", painted(note, Style::Dim, colors))?;
    }
    writeln!(out)
}

/// A table whose cells are as wide as they are shown.
fn shown(table: &Table) -> Table {
    let cell = |cell: &Cell| Cell { text: line(&cell.text).into_owned(), style: cell.style };
    Table {
        title: table.title.clone(),
        header: table.header.clone(),
        rows: table.rows.iter().map(|row| row.iter().map(cell).collect()).collect(),
        notes: table.notes.clone(),
    }
}

/// Text on one line with the escape sequences of a style.
pub fn painted(text: &str, style: Style, colors: bool) -> String {
    let [end, bad, best, dim] = COLORS;
    let begin = match style {
        Style::Bad => bad,
        Style::Best => best,
        Style::Dim => dim,
        Style::Plain => "",
    };
    let text = line(text);
    if colors && style != Style::Plain { format!("{begin}{text}{end}") } else { text.into_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_from_outside_are_text() {
        assert_eq!(painted("\u{1b}[31mx", Style::Plain, true), "\\u001b[31mx");
        assert_eq!(painted("x", Style::Bad, true), "\u{1b}[31mx\u{1b}[0m");
        let name = "a\u{1b}[2K\n::error::b";
        let rows = vec![vec![Cell::from(name.to_owned()), Cell::from("1".to_owned())]];
        let table =
            Table { title: name.into(), header: vec!["x", "y"], rows, notes: vec![name.into()] };
        let mut out = Vec::new();
        write_table(&mut out, &table, false).unwrap();
        let text = String::from_utf8(out).unwrap();
        assert_eq!(text.matches("a\\u001b[2K\\n::error::b").count(), 3, "{text}");
        assert_eq!(text.lines().count(), 5, "{text}");
        // as wide as they are shown
        let at = |line: usize| text.lines().nth(line).unwrap().chars().count();
        assert_eq!(at(1), at(2), "{text}");
    }
}
