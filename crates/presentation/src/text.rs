//! Tables and lines for the terminal, so wide that they fit: columns of least weight are left out, names
//! go on in the next line.

use std::io::{self, Write};

use crate::outside::{COLORS, line};
use crate::table::{Cell, Style, Table};

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

    pub fn write_notes(self, out: &mut dyn Write, lines: &[&str]) -> io::Result<()> {
        for text in lines {
            for part in wrapped(&line(text), self.width, 0) {
                writeln!(out, "{}", painted(&part, Style::Dim, self.colors))?;
            }
        }
        Ok(())
    }

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
    let mut table = table.clone();
    for cell in table.rows.iter_mut().flatten() {
        cell.text = line(&cell.text).into_owned();
    }
    table
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

pub const GAP: usize = 2;

/// The narrowest that names and closing words are made.
const NARROWEST: [usize; 2] = [24, 12];

/// The table with those of its columns that fit into lines of so many characters, and the heads of
/// the others. The first column stays in any case; the others are taken in the order of `first`,
/// then in their own.
pub fn fitted(table: &Table, width: usize, first: &[&str]) -> (Table, Vec<&'static str>) {
    let natural = natural(table);
    let [names, last] = limits(table, &natural, width);
    let needed = |column: usize| match column {
        0 => names,
        c if c + 1 == natural.len() => GAP + last,
        c => GAP + natural.get(c).copied().unwrap_or(0),
    };
    let place = |head: &&str| first.iter().position(|f| f == head).unwrap_or(first.len());
    let mut by_weight: Vec<usize> = (1..table.header.len()).collect();
    by_weight.sort_by_key(|c| table.header.get(*c).map(place));
    let mut kept = vec![0];
    let mut used = needed(0);
    for column in by_weight {
        if used + needed(column) <= width {
            used += needed(column);
            kept.push(column);
        }
    }
    let left_out = (0..table.header.len()).filter(|c| !kept.contains(c));
    let left_out = left_out.filter_map(|c| table.header.get(c).copied()).collect();
    kept.sort_unstable();
    (with_columns(table, &kept), left_out)
}

/// The table with its columns at those places alone, in that order.
pub fn with_columns(table: &Table, columns: &[usize]) -> Table {
    let of = |row: &Vec<Cell>| columns.iter().filter_map(|c| row.get(*c)).cloned().collect();
    Table {
        title: table.title.clone(),
        header: columns.iter().filter_map(|c| table.header.get(*c)).copied().collect(),
        rows: table.rows.iter().map(of).collect(),
        notes: table.notes.clone(),
    }
}

/// How wide the columns of a table are that is printed within a width, the first and the last of
/// them cut.
pub fn widths(table: &Table, width: usize) -> Vec<usize> {
    let mut widths = natural(table);
    let all: usize = widths.iter().sum::<usize>() + GAP * widths.len().saturating_sub(1);
    if all <= width || widths.len() < 2 {
        return widths;
    }
    let [names, last] = limits(table, &widths, width);
    if let Some(end) = widths.last_mut() {
        *end = last;
    }
    // what is over is left to the names
    let others: usize = widths.iter().skip(1).map(|w| w + GAP).sum();
    if let Some(first) = widths.first_mut() {
        *first = names.max(width.saturating_sub(others)).min(*first);
    }
    widths
}

/// Maximum width of the first column and the last; figures are not wrapped.
fn limits(table: &Table, natural: &[usize], width: usize) -> [usize; 2] {
    let [name, last] = [natural.first(), natural.last()].map(|w| w.copied().unwrap_or(0));
    let cut = if ends_in_words(table) { (width / 5).max(NARROWEST[1]) } else { last };
    [name.min((width * 2 / 5).max(NARROWEST[0])), last.min(cut)]
}

/// Returns whether most cells of the last column begin with a letter.
fn ends_in_words(table: &Table) -> bool {
    let is_words = |cell: &&Cell| cell.text.starts_with(char::is_alphabetic);
    let last = || table.rows.iter().filter_map(|row| row.last());
    2 * last().filter(is_words).count() > last().count()
}

fn natural(table: &Table) -> Vec<usize> {
    let of = |c: usize| {
        let cells = table.rows.iter().filter_map(|row| row.get(c));
        let cells = cells.map(|cell| cell.text.chars().count());
        let head = table.header.get(c).map_or(0, |head| head.chars().count());
        cells.chain([head]).max().unwrap_or(0)
    };
    (0..table.header.len()).map(of).collect()
}

/// Text in lines of so many characters, broken at spaces where there are any; those after the first
/// begin with so many spaces.
pub fn wrapped(text: &str, width: usize, indent: usize) -> Vec<String> {
    let width = width.max(indent + 1);
    let mut lines = Vec::new();
    let mut line = String::new();
    let mut used = 0;
    let begin = text.len() - text.trim_start().len();
    let (before, text) = text.split_at(begin);
    line.push_str(before);
    used += before.chars().count();
    let mut is_empty = true;
    for word in text.split(' ') {
        let mut word: Vec<char> = word.chars().collect();
        if !is_empty && used + 1 + word.len() > width {
            lines.push(std::mem::replace(&mut line, " ".repeat(indent)));
            (used, is_empty) = (indent, true);
        }
        if !is_empty {
            line.push(' ');
            used += 1;
        }
        while used + word.len() > width {
            let rest = word.split_off(width.saturating_sub(used).max(1).min(word.len()));
            line.extend(word);
            lines.push(std::mem::replace(&mut line, " ".repeat(indent)));
            (used, word) = (indent, rest);
        }
        used += word.len();
        line.extend(word);
        is_empty = false;
    }
    lines.push(line);
    lines
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

    fn table() -> Table {
        let row = |name: &'static str| [name, "1234567890", "12345", "ok on 25518 shadow rays"];
        let cells = |row: [&str; 4]| row.map(|t| Cell::from(t.to_owned())).into();
        Table {
            title: "t".into(),
            header: vec!["structure", "wide", "small", "verdict"],
            rows: vec![cells(row("grid")), cells(row("grid resolution=heterogeneous density=20"))],
            notes: vec!["note".into()],
        }
    }

    #[test]
    fn columns_of_most_weight_are_kept_in_their_order() {
        let (all, left_out) = fitted(&table(), 200, &[]);
        assert_eq!((all, left_out.len()), (table(), 0));
        let (some, left_out) = fitted(&table(), 50, &["small", "verdict"]);
        assert_eq!(some.header, ["structure", "small", "verdict"]);
        assert_eq!(left_out, ["wide"]);
        assert_eq!((some.rows[0].len(), some.notes.len()), (3, 1));
        // what is too wide makes room for what is not
        let (some, _) = fitted(&table(), 33, &["wide", "small"]);
        assert_eq!(some.header, ["structure", "small"]);
        let (least, _) = fitted(&table(), 1, &[]);
        assert_eq!(least.header, ["structure"]);
    }

    #[test]
    fn the_name_column_gets_the_remaining_width() {
        assert_eq!(widths(&table(), 200), [40, 10, 5, 23]);
        let widths = widths(&table(), 70);
        assert_eq!(widths.iter().sum::<usize>() + 3 * GAP, 70);
        assert_eq!(widths[3], 14);
    }

    #[test]
    fn figures_in_the_last_column_are_not_wrapped() {
        let (some, _) = fitted(&table(), 50, &["wide", "small"]);
        assert_eq!(some.header, ["structure", "wide", "small"]);
        assert_eq!(widths(&some, 40)[1..], [10, 5]);
        assert_eq!(widths(&some, 10)[1..], [10, 5]);
    }

    #[test]
    fn text_is_broken_at_spaces_and_words_where_there_are_none() {
        assert_eq!(wrapped("one two three", 9, 2), ["one two", "  three"]);
        assert_eq!(wrapped("  ab cd", 5, 4), ["  ab", "    c", "    d"]);
        assert_eq!(wrapped("abcdefgh", 4, 1), ["abcd", " efg", " h"]);
        assert_eq!(wrapped("", 4, 1), [""]);
        assert_eq!(wrapped("a b", 0, 0), ["a", "b"]);
        let text = "the quick brown fox jumps over the lazy dog";
        for width in 5..50 {
            let lines = wrapped(text, width, 0);
            assert!(lines.iter().all(|l| l.chars().count() <= width), "{lines:?}");
            assert_eq!(lines.join(" "), text);
        }
    }
}
