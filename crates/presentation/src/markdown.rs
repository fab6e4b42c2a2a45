//! Tables in Markdown.

use std::fmt::Write;

use crate::outside;
use crate::table::Table;

/// Appends a table with its title and notes; all columns but the first hold figures.
pub fn push_table(text: &mut String, table: &Table) {
    push_table_with(text, table, |column| column > 0);
}

/// The same; `holds_figures` says which columns are aligned to the right.
pub fn push_table_with(text: &mut String, table: &Table, holds_figures: impl Fn(usize) -> bool) {
    let _ = writeln!(text, "## {}\n", escaped(&table.title));
    let _ = writeln!(text, "| {} |", table.header.join(" | "));
    let rule: Vec<&str> = (0..table.header.len())
        .map(|column| if holds_figures(column) { "---:" } else { "---" })
        .collect();
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

/// Text of a paragraph, a cell or a list, and nothing but text: no markup, no link, no end of a
/// cell.
pub fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len() + 8);
    let mut previous = ' ';
    for c in outside::line(text).chars() {
        match (previous, c) {
            (_, '<') => out.push_str("&lt;"),
            (_, '&') => out.push_str("&amp;"),
            (_, '\\' | '|' | '_' | '`' | '*' | '~') | ('!', '[') | (']', '(' | ':') => {
                out.push('\\');
                out.push(c);
            }
            _ => out.push(c),
        }
        previous = c;
    }
    out
}

/// Text as code, whatever it holds.
pub fn code(text: &str) -> String {
    let text = outside::line(text);
    let longest = text.split(|c| c != '`').map(str::len).max().unwrap_or(0);
    let fence = "`".repeat(longest + 1);
    let space = if longest > 0 { " " } else { "" };
    format!("{fence}{space}{text}{space}{fence}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_stays_text() {
        for (text, expected) in [
            ("a|b<img src=x>", "a\\|b&lt;img src=x>"),
            ("`c`\nd\r", "\\`c\\`\\\\nd\\\\r"),
            ("[x](http://y) ![z](w)", "[x]\\(http://y) !\\[z]\\(w)"),
            ("1.05 [1.01, 1.09]", "1.05 [1.01, 1.09]"),
            ("*a* ~~b~~ _c_", "\\*a\\* \\~\\~b\\~\\~ \\_c\\_"),
        ] {
            assert_eq!(escaped(text), expected);
        }
        assert_eq!(code("run -s x"), "`run -s x`");
        assert_eq!(code("a`` `b\n"), "``` a`` `b\\n ```");
    }
}
