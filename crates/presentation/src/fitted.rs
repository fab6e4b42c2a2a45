//! Tables and lines that fit a terminal: columns of least weight are left out, names go on in the
//! next line.

use crate::table::{Cell, Table};

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
