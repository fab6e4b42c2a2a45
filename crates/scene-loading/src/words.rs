//! Words of a free-form text with their line numbers, and the checked numbers of NFF.

use std::fmt::Display;
use std::path::Path;

use glam::DVec3;

use crate::error::{FilePlace, LoadError, shortened};

/// A word and the line it stands on.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Word<'a> {
    pub text: &'a str,
    pub line: usize,
    /// It stands in quotation marks, which are no part of its text.
    pub is_quoted: bool,
}

impl Word<'_> {
    /// True for words that begin as a number does. No keyword of NFF does.
    pub fn looks_numeric(&self) -> bool {
        self.text.starts_with(|c: char| c.is_ascii_digit() || matches!(c, '+' | '-' | '.'))
    }
}

/// Splits a text at white space; comments run to the end of the line.
pub(crate) struct Words<'a> {
    pub path: &'a Path,
    rest: &'a str,
    line: usize,
    comments: &'static [char],
    stops: &'static [u8],
    is_unclosed: bool,
}

impl<'a> Words<'a> {
    /// The words of a text in which `#` starts a comment, as in NFF.
    pub fn new(path: &'a Path, text: &'a str) -> Self {
        Self { path, rest: text, line: 1, comments: &['#'], stops: b"", is_unclosed: false }
    }

    /// With other characters that start comments, and ASCII characters that end a word wherever
    /// they stand and are a word of their own. A quotation mark among those begins a quoted word.
    pub fn with_syntax(self, comments: &'static [char], stops: &'static [u8]) -> Self {
        Self { comments, stops, ..self }
    }

    /// Bytes not yet read: an upper bound for what the file can still hold.
    pub fn remaining(&self) -> usize {
        self.rest.len()
    }

    pub fn place(&self, line: usize) -> FilePlace {
        FilePlace::line(self.path, line)
    }

    /// The next word, and the bytes that it takes. None from a quoted word on that its line does
    /// not close.
    fn scan(&mut self) -> Option<(Word<'a>, usize)> {
        loop {
            let (mut blanks, mut lines) = (0, 0);
            for b in self.rest.bytes().take_while(u8::is_ascii_whitespace) {
                blanks += 1;
                lines += usize::from(b == b'\n');
            }
            self.line += lines;
            let text = self.rest.get(blanks..).unwrap_or("");
            self.rest = text;
            if !text.starts_with(self.comments) {
                break;
            }
            self.rest = text.find('\n').and_then(|end| text.get(end..)).unwrap_or("");
        }
        let (text, line) = (self.rest, self.line);
        let first = *text.as_bytes().first()?;
        let is_stop = |b: u8| !self.stops.is_empty() && self.stops.contains(&b);
        if first == b'"' && is_stop(first) {
            let inner = text.get(1..)?;
            let quoted = inner.lines().next().and_then(|line| line.split_once('"'));
            let Some((text, _)) = quoted else {
                (self.rest, self.is_unclosed) = ("", true);
                return None;
            };
            return Some((Word { text, line, is_quoted: true }, text.len() + 2));
        }
        let end = text.bytes().position(|b| b.is_ascii_whitespace() || is_stop(b));
        let length = if is_stop(first) { 1 } else { end.unwrap_or(text.len()) };
        Some((Word { text: text.get(..length)?, line, is_quoted: false }, length))
    }

    /// The next word, left in place.
    pub fn peek(&mut self) -> Option<Word<'a>> {
        self.scan().map(|(word, _)| word)
    }

    /// Takes the next word.
    pub fn next(&mut self) -> Option<Word<'a>> {
        let (word, length) = self.scan()?;
        self.rest = self.rest.get(length..).unwrap_or("");
        Some(word)
    }

    /// Refuses a quoted word without an end.
    pub fn check_closed(&self) -> Result<(), LoadError> {
        if self.is_unclosed { Err(self.ended("the end of a quoted string")) } else { Ok(()) }
    }

    fn ended(&self, expected: impl Display) -> LoadError {
        LoadError::unexpected_end(self.place(self.line), expected)
    }

    /// True when these two words come next, in any case, without a comment between them.
    pub fn are_next(&self, expected: [&str; 2]) -> bool {
        let mut words = self.rest.split_ascii_whitespace();
        expected.iter().all(|word| words.next().is_some_and(|w| w.eq_ignore_ascii_case(word)))
    }

    /// The next word, whatever it is.
    pub fn any(&mut self, what: impl Display) -> Result<Word<'a>, LoadError> {
        let word = self.next();
        self.check_closed()?;
        word.ok_or_else(|| self.ended(what))
    }

    /// Takes a word that must be this one, in any case.
    pub fn keyword(&mut self, expected: &str) -> Result<(), LoadError> {
        let word = self.any(expected)?;
        if word.text.eq_ignore_ascii_case(expected) {
            return Ok(());
        }
        Err(LoadError::syntax(self.place(word.line), word.text, expected))
    }

    pub fn number(&mut self, what: impl Display + Copy) -> Result<f64, LoadError> {
        let word = self.any(what)?;
        let value: f64 = word.text.parse().map_err(|_| {
            LoadError::syntax(self.place(word.line), word.text, format!("a number ({what})"))
        })?;
        if !value.is_finite() {
            let (place, found) = (self.place(word.line), shortened(word.text));
            return Err(LoadError::not_finite(place, what, found));
        }
        Ok(value)
    }

    pub fn vector(&mut self, what: impl Display + Copy) -> Result<DVec3, LoadError> {
        Ok(DVec3::new(self.number(what)?, self.number(what)?, self.number(what)?))
    }

    /// A whole number in `min..=max`.
    pub fn integer(&mut self, what: &str, min: u64, max: u64) -> Result<u64, LoadError> {
        let word = self.any(what)?;
        let value: u64 = word.text.parse().map_err(|_| {
            let expected = format!("a whole number from {min} ({what})");
            LoadError::syntax(self.place(word.line), word.text, expected)
        })?;
        if value < min {
            let (place, expected) = (self.place(word.line), format!("at least {min}"));
            return Err(LoadError::out_of_range(place, what, value, expected));
        }
        if value > max {
            return Err(LoadError::too_many(self.place(word.line), what, value, max));
        }
        Ok(value)
    }
}
