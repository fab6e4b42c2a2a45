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
}

impl Word<'_> {
    /// True for words that begin as a number does. No keyword of NFF does.
    pub fn looks_numeric(&self) -> bool {
        self.text.starts_with(|c: char| c.is_ascii_digit() || matches!(c, '+' | '-' | '.'))
    }
}

/// Splits a text at white space; `#` starts a comment that runs to the end of the line.
pub(crate) struct Words<'a> {
    path: &'a Path,
    rest: &'a str,
    line: usize,
    comments: &'static [char],
}

impl<'a> Words<'a> {
    pub fn new(path: &'a Path, text: &'a str) -> Self {
        Self { path, rest: text, line: 1, comments: &['#'] }
    }

    /// With other characters that start comments.
    pub fn with_comments(self, comments: &'static [char]) -> Self {
        Self { comments, ..self }
    }

    /// Bytes not yet read: an upper bound for what the file can still hold.
    pub fn remaining(&self) -> usize {
        self.rest.len()
    }

    pub fn place(&self, line: usize) -> FilePlace {
        FilePlace::line(self.path, line)
    }

    /// The next word, left in place.
    pub fn peek(&mut self) -> Option<Word<'a>> {
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
        let end = self.rest.bytes().position(|b| b.is_ascii_whitespace());
        let word = self.rest.get(..end.unwrap_or(self.rest.len()))?;
        (!word.is_empty()).then_some(Word { text: word, line: self.line })
    }

    /// Takes the next word.
    pub fn next(&mut self) -> Option<Word<'a>> {
        let word = self.peek()?;
        self.rest = self.rest.get(word.text.len()..).unwrap_or("");
        Some(word)
    }

    /// True when these two words come next, in any case, without a comment between them.
    pub fn are_next(&self, expected: [&str; 2]) -> bool {
        let mut words = self.rest.split_ascii_whitespace();
        expected.iter().all(|word| words.next().is_some_and(|w| w.eq_ignore_ascii_case(word)))
    }

    /// The next word, whatever it is.
    pub fn any(&mut self, what: impl Display) -> Result<Word<'a>, LoadError> {
        self.next().ok_or_else(|| LoadError::unexpected_end(self.place(self.line), what))
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
