//! Text from outside, where it is printed: names of files and scenes, words of records and
//! journals, messages of the system. Whatever it holds, it stays text. It gives no orders to a
//! terminal (escape sequences, line ends, marks that turn the direction of writing), to a CI job
//! (lines that begin with `::`, and `##[` anywhere), to a spreadsheet (`=`), or to whatever shows
//! Markdown (`<`, `|`).
//!
//! Cells, titles and notes of tables, Markdown and CSV, warnings and errors go through [`line()`]
//! or [`message`]; everything on standard output and standard error goes through a [`Guard`] as
//! well, so that nothing depends on a call that was forgotten. What is hidden is shown as JSON
//! writes it, so that JSON on standard output stays JSON.

use std::borrow::Cow;
use std::fmt;
use std::io::{self, Write};

/// Escape sequences that end a colour and begin ours: bad, best, of little weight. Any other escape
/// sequence is text from outside.
pub const COLORS: [&str; 4] = ["\x1b[0m", "\x1b[31m", "\x1b[1m", "\x1b[2m"];

/// Returns whether a character would be obeyed, not shown: control characters of both sets, line
/// and paragraph separators, and what turns or hides text. No newer form of these lies beyond four
/// hex digits.
pub fn is_hidden(c: char) -> bool {
    c.is_control()
        || matches!(
            c,
            '\u{61c}' | '\u{200b}' | '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}'
                | '\u{2066}'..='\u{2069}' | '\u{feff}'
        )
}

/// Text on one line, what is hidden shown.
pub fn line(text: &str) -> Cow<'_, str> {
    if !text.contains(is_hidden) {
        return Cow::Borrowed(text);
    }
    let mut out = String::with_capacity(text.len() + 8);
    text.chars().for_each(|c| if is_hidden(c) { push_escaped(&mut out, c) } else { out.push(c) });
    Cow::Owned(out)
}

/// An error or a warning: one line, and further ones only where they are indented, as lists are.
pub fn message(text: &str) -> String {
    let mut lines = text.split("\n  ");
    let mut out = line(lines.next().unwrap_or_default()).into_owned();
    for more in lines {
        out.push_str("\n  ");
        out.push_str(&line(more));
    }
    out
}

/// A field of CSV: no formula, but numbers stay numbers.
pub fn field(text: &str) -> Cow<'_, str> {
    let is_formula = text.len() > 1 && text.starts_with(['=', '+', '-', '@']);
    match line(text) {
        text if is_formula && text.parse::<f64>().is_err() => Cow::Owned(format!("'{text}")),
        text => text,
    }
}

fn push_escaped(out: &mut String, c: char) {
    match c {
        '\n' => out.push_str("\\n"),
        '\r' => out.push_str("\\r"),
        '\t' => out.push_str("\\t"),
        c => out.push_str(&format!("\\u{:04x}", u32::from(c))),
    }
}

/// An annotation of GitHub Actions: the only line that is meant as an order.
///
/// Source: GitHub's documentation, "Workflow commands for GitHub Actions": `::error title=T::text`
/// on a line of its own, with percent signs and line ends escaped, in titles colons and commas too.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Annotation {
    /// `error` or `warning`.
    pub level: &'static str,
    pub title: String,
    pub text: String,
}

impl fmt::Display for Annotation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let data = |text: &str| line(text).replace('%', "%25");
        let title = data(&self.title).replace(':', "%3A").replace(',', "%2C");
        write!(f, "::{} title={title}::{}", self.level, data(&self.text))
    }
}

/// Content of a line so far.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum LineContent {
    Blank,
    /// Blanks and a colon.
    Colon,
    /// Something, and so many number signs just now.
    Signs(u8),
}

/// A writer that lets text through, and our own colours, and nothing that gives orders. Characters
/// and colours must not be cut by the end of a write.
#[derive(Debug)]
pub struct Guard<W> {
    to: W,
    seen: LineContent,
}

impl<W: Write> Guard<W> {
    /// Guards what is written there, from the beginning of a line.
    pub fn new(to: W) -> Self {
        Self { to, seen: LineContent::Blank }
    }

    fn push(&mut self, c: char, out: &mut String) {
        let seen = std::mem::replace(&mut self.seen, LineContent::Signs(0));
        match (c, seen) {
            ('\n', _) => {
                self.seen = LineContent::Blank;
                out.push(c);
            }
            (':', LineContent::Colon) | ('[', LineContent::Signs(2)) => {
                out.push_str(if c == ':' { "\\u003a" } else { "\\u005b" });
            }
            (c, _) if c != '\t' && is_hidden(c) => push_escaped(out, c),
            (c, _) => {
                self.seen = match (c, seen) {
                    (':', LineContent::Blank) => LineContent::Colon,
                    (c, LineContent::Blank) if c.is_whitespace() => LineContent::Blank,
                    ('#', LineContent::Signs(n)) => LineContent::Signs(u8::min(n + 1, 2)),
                    ('#', _) => LineContent::Signs(1),
                    _ => LineContent::Signs(0),
                };
                out.push(c);
            }
        }
    }
}

impl<W: Write> Write for Guard<W> {
    fn write(&mut self, buffer: &[u8]) -> io::Result<usize> {
        let text = String::from_utf8_lossy(buffer);
        let mut out = String::with_capacity(text.len());
        let mut rest = &*text;
        while let Some(c) = rest.chars().next() {
            let colour = COLORS.iter().find_map(|s| Some((*s, rest.strip_prefix(s)?)));
            rest = match colour {
                Some((sequence, behind)) => {
                    out.push_str(sequence);
                    behind
                }
                None => {
                    self.push(c, &mut out);
                    rest.get(c.len_utf8()..).unwrap_or_default()
                }
            };
        }
        self.to.write_all(out.as_bytes())?;
        Ok(buffer.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        self.to.flush()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Orders to terminals: colours, a title, one byte that stands for `ESC [`, a cleared line,
    /// text from right to left.
    const ORDERS: &str =
        "a\u{1b}[31mb\u{1b}]0;t\u{7}c\u{9b}2Jd\r\ne\u{202e}f\u{2066}g\u{7f}\u{2028}";

    fn guarded(pieces: &[&str]) -> String {
        let mut out = Vec::new();
        let mut guard = Guard::new(&mut out);
        pieces.iter().for_each(|piece| guard.write_all(piece.as_bytes()).unwrap());
        guard.flush().unwrap();
        String::from_utf8(out).unwrap()
    }

    #[test]
    fn control_characters_are_escaped() {
        let shown = line(ORDERS);
        assert!(!shown.contains(is_hidden), "{shown:?}");
        let expected =
            "a\\u001b[31mb\\u001b]0;t\\u0007c\\u009b2Jd\\r\\ne\\u202ef\\u2066g\\u007f\\u2028";
        assert_eq!(shown, expected);
        assert_eq!(line("café |<`").as_ref(), "café |<`");
        assert_eq!(message("a\nb\n  c\r"), "a\\nb\n  c\\r");
    }

    #[test]
    fn fields_are_no_formulas_and_numbers_stay() {
        for (text, expected) in [
            ("=1+1", "'=1+1"),
            ("@SUM(A1)", "'@SUM(A1)"),
            ("+cmd|' /C calc'!A0", "'+cmd|' /C calc'!A0"),
            ("-2+3", "'-2+3"),
            ("\t=1", "\\t=1"),
            ("\r=1", "\\r=1"),
            ("-0.250000000", "-0.250000000"),
            ("-1e-9", "-1e-9"),
            ("-inf", "-inf"),
            ("-", "-"),
            ("plain", "plain"),
        ] {
            assert_eq!(field(text), expected, "{text}");
        }
    }

    #[test]
    fn workflow_commands_are_defused() {
        assert_eq!(guarded(&["::error title=x::a\n"]), ":\\u003aerror title=x::a\n");
        assert_eq!(guarded(&["a\n", " \t:", ":b\n"]), "a\n \t:\\u003ab\n");
        assert_eq!(guarded(&["x ::y\n:z::\n"]), "x ::y\n:z::\n");
        assert_eq!(
            guarded(&["x ##[error]a ##", "[b] ###[c] # #[\n"]),
            "x ##\\u005berror]a ##\\u005bb] ###\\u005bc] # #[\n"
        );
        assert_eq!(guarded(&["##", "[group]"]), "##\\u005bgroup]");
        let annotation =
            Annotation { level: "error", title: "a:b,c".into(), text: "d%\n::e".into() };
        assert_eq!(annotation.to_string(), "::error title=a%3Ab%2Cc::d%25\\n::e");
    }

    #[test]
    fn colours_are_ours_and_the_rest_is_shown() {
        assert_eq!(guarded(&["\u{1b}[31mx\u{1b}[0m"]), "\u{1b}[31mx\u{1b}[0m");
        for order in ["\u{1b}[2J", "\u{1b}]0;t\u{7}", "\u{1b}[32mx", "\u{9b}1m", "\r", "\u{202e}"] {
            assert!(!guarded(&[order]).contains(is_hidden), "{order:?}");
        }
    }

    #[test]
    fn json_stays_json() {
        let text = serde_json::to_string(&format!("{ORDERS} ##[x]")).unwrap();
        let shown = guarded(&[&text]);
        assert!(!shown.contains(is_hidden), "{shown:?}");
        let back: String = serde_json::from_str(&shown).unwrap();
        assert_eq!(back, format!("{ORDERS} ##[x]"));
    }
}
