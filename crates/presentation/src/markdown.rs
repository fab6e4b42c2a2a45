//! Tables in Markdown.

use std::fmt::Write;

use crate::table::Table;

/// Appends a table with its title and notes.
pub fn push_table(text: &mut String, table: &Table) {
    let _ = writeln!(text, "## {}\n", escaped(&table.title));
    let _ = writeln!(text, "| {} |", table.header.join(" | "));
    let rule: Vec<&str> =
        (0..table.header.len()).map(|c| if c == 0 { "---" } else { "---:" }).collect();
    let _ = writeln!(text, "| {} |", rule.join(" | "));
    for row in &table.rows {
        let cells: Vec<String> = row.iter().map(|c| escaped(&c.text)).collect();
        let _ = writeln!(text, "| {} |", cells.join(" | "));
    }
    text.push('\n');
    for note in &table.notes {
        let _ = writeln!(text, "{}\n", escaped(note));
    }
}

/// Keeps text from breaking out of its cell.
fn escaped(text: &str) -> String {
    text.replace('\\', "\\\\").replace('|', "\\|").replace(['\n', '\r'], " ").replace('_', "\\_")
}
