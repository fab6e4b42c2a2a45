//! Tables for the terminal.

use std::io::{self, Write};

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

/// Text with the escape sequences of a style.
pub fn painted(text: &str, style: Style, colors: bool) -> String {
    let code = match style {
        Style::Plain => return text.to_owned(),
        Style::Bad => "31",
        Style::Best => "1",
        Style::Dim => "2",
    };
    if colors { format!("\x1b[{code}m{text}\x1b[0m") } else { text.to_owned() }
}
