//! Tables for the terminal.

use std::io::{self, Write};

use crate::fitted::{fitted, widths, wrapped};
use crate::outside::{COLORS, line};
use crate::table::{Cell, Style, Table};

/// Target of printed text.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Screen {
    /// Characters of a line.
    pub width: usize,
    pub colors: bool,
    /// Tables have all their columns, however wide; other text keeps to the width.
    pub is_wide: bool,
}

impl Screen {
    /// Lines of any length, without colours.
    pub const UNLIMITED: Self = Self { width: 1 << 16, colors: false, is_wide: true };

    /// Prints lines of little weight.
    pub fn write_notes(self, out: &mut dyn Write, lines: &[&str]) -> io::Result<()> {
        for text in lines {
            for part in wrapped(&line(text), self.width, 0) {
                writeln!(out, "{}", painted(&part, Style::Dim, self.colors))?;
            }
        }
        Ok(())
    }

    /// Prints a line of words.
    pub fn write_line(self, out: &mut dyn Write, text: &str) -> io::Result<()> {
        self.write_item(out, text, 2)
    }

    /// Prints a line whose continuations are indented by this many spaces.
    pub fn write_item(self, out: &mut dyn Write, text: &str, indent: usize) -> io::Result<()> {
        wrapped(&line(text), self.width, indent).iter().try_for_each(|part| writeln!(out, "{part}"))
    }

    /// Prints a table with those of its columns that fit, the heads of `first` before others, and
    /// names the columns that do not.
    pub fn write_fitted(
        self,
        out: &mut dyn Write,
        table: &Table,
        first: &[&str],
    ) -> io::Result<()> {
        let (mut table, left_out) = fitted(table, self.table_width(), first);
        if !left_out.is_empty() {
            table
                .notes
                .push(format!("Columns that do not fit: {}; files have all.", left_out.join(", ")));
        }
        self.write_table(out, &table)
    }

    /// Prints all columns of a table: names and words at the end go on in the next line.
    pub fn write_table(self, out: &mut dyn Write, table: &Table) -> io::Result<()> {
        let table = &shown(table);
        let widths = widths(table, self.table_width());
        for part in wrapped(&table.title, self.width, 2) {
            writeln!(out, "{}", painted(&part, Style::Best, self.colors))?;
        }
        let header: Vec<Cell> = table.header.iter().map(|h| (*h).to_owned().into()).collect();
        for row in std::iter::once(&header).chain(&table.rows) {
            write_row(out, row, &widths, self.colors)?;
        }
        let notes: Vec<&str> = table.notes.iter().map(String::as_str).collect();
        self.write_notes(out, &notes)?;
        writeln!(out)
    }

    fn table_width(self) -> usize {
        if self.is_wide { Self::UNLIMITED.width } else { self.width }
    }
}

/// Names left, numbers right, the last column left; what is wider than its column goes on below it.
fn write_row(out: &mut dyn Write, row: &[Cell], widths: &[usize], colors: bool) -> io::Result<()> {
    let last = row.len().saturating_sub(1);
    let parts: Vec<Vec<String>> = row
        .iter()
        .zip(widths)
        .enumerate()
        .map(|(c, (cell, width))| match c {
            0 => wrapped(&cell.text, *width, 4.min(width / 2)),
            _ if c == last => wrapped(&cell.text, *width, 0),
            _ => vec![cell.text.clone()],
        })
        .collect();
    let height = parts.iter().map(Vec::len).max().unwrap_or(0);
    for i in 0..height {
        let mut pending = String::new();
        for (c, (cell, &width)) in row.iter().zip(widths).enumerate() {
            let part = parts.get(c).and_then(|p| p.get(i)).map_or("", String::as_str);
            let text = match c {
                0 => format!("{part:<width$}"),
                _ if c == last => format!("  {part}"),
                _ => format!("  {part:>width$}"),
            };
            // lines that go on end where their text ends
            if i > 0 && part.is_empty() {
                pending += &text;
                continue;
            }
            write!(out, "{pending}{}", painted(&text, cell.style, colors))?;
            pending.clear();
        }
        writeln!(out)?;
    }
    Ok(())
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
    fn a_table_fits_the_screen_and_names_omitted_columns() {
        let row = ["grid density=4", "1234567890", "12345"].map(|t| Cell::from(t.to_owned()));
        let header = vec!["structure", "wide", "small"];
        let table = Table { title: "t ".repeat(20), header, rows: vec![row.into()], notes: vec![] };
        let printed = |width| {
            let mut out = Vec::new();
            let screen = Screen { width, colors: false, is_wide: false };
            screen.write_fitted(&mut out, &table, &["small"]).unwrap();
            screen.write_notes(&mut out, &["so many words"]).unwrap();
            screen.write_line(&mut out, &"word ".repeat(20)).unwrap();
            String::from_utf8(out).unwrap()
        };
        for width in [24, 40, 120] {
            let text = printed(width);
            assert!(
                text.lines().all(|l| l.trim_end().chars().count() <= width),
                "{width}:\n{text}"
            );
            let words = text.split_whitespace().collect::<Vec<_>>().join(" ");
            let is_named = words.contains("Columns that do not fit: wide;");
            assert_eq!(is_named, width == 24, "{text}");
        }
        assert!(printed(24).contains("12345") && !printed(24).contains("1234567890"));
    }

    #[test]
    fn wide_tables_keep_prose_within_the_width() {
        let row = vec![Cell::from("name ".repeat(20)), Cell::from("1".to_owned())];
        let (title, note) = ("title ".repeat(20), "note ".repeat(20));
        let table = Table { title, header: vec!["x", "y"], rows: vec![row], notes: vec![note] };
        let mut out = Vec::new();
        let screen = Screen { width: 40, colors: false, is_wide: true };
        screen.write_fitted(&mut out, &table, &[]).unwrap();
        let text = String::from_utf8(out).unwrap();
        let too_long = text.lines().filter(|line| line.trim_end().chars().count() > 40);
        assert_eq!(too_long.count(), 2, "the table alone: {text}");
    }

    #[test]
    fn colours_from_outside_are_text() {
        assert_eq!(painted("\u{1b}[31mx", Style::Plain, true), "\\u001b[31mx");
        assert_eq!(painted("x", Style::Bad, true), "\u{1b}[31mx\u{1b}[0m");
        let name = "a\u{1b}[2K\n::error::b";
        let rows = vec![vec![Cell::from(name.to_owned()), Cell::from("1".to_owned())]];
        let table =
            Table { title: name.into(), header: vec!["x", "y"], rows, notes: vec![name.into()] };
        let mut out = Vec::new();
        Screen::UNLIMITED.write_table(&mut out, &table).unwrap();
        let text = String::from_utf8(out).unwrap();
        assert_eq!(text.matches("a\\u001b[2K\\n::error::b").count(), 3, "{text}");
        assert_eq!(text.lines().count(), 5, "{text}");
        // as wide as they are shown
        let at = |line: usize| text.lines().nth(line).unwrap().chars().count();
        assert_eq!(at(1), at(2), "{text}");
    }
}
