//! What the words of PBRT files are: directives, numbers, brackets and quoted strings.

use crate::error::LoadError;
use crate::limits::{self, MAX_NAME};
use crate::mesh::coordinate;
use crate::words::{Word, Words};

impl Word<'_> {
    pub(super) fn number(self) -> Option<f64> {
        if self.is_quoted { None } else { self.text.parse().ok() }
    }

    /// A word that begins a new statement.
    pub(super) fn is_directive(self) -> bool {
        !self.is_quoted
            && !matches!(self.text, "true" | "false")
            && self.number().is_none()
            && self.text.starts_with(|c: char| c.is_ascii_alphabetic())
    }

    pub(super) fn is_bracket(self, bracket: &str) -> bool {
        !self.is_quoted && self.text == bracket
    }
}

impl<'a> Words<'a> {
    /// With the comments, brackets and quotation marks of PBRT.
    pub(super) fn of_pbrt(self) -> Self {
        self.with_syntax(&['#'], b"[]\"#")
    }

    /// The next word, which must be a quoted string.
    pub(super) fn quoted(&mut self, expected: &str) -> Result<Word<'a>, LoadError> {
        let word = self.any(expected)?;
        if word.is_quoted {
            return Ok(word);
        }
        Err(LoadError::syntax(self.place(word.line), word.text, format!("\"{expected}\"")))
    }

    /// A quoted string of a length that names may have.
    pub(super) fn name(&mut self, expected: &str) -> Result<String, LoadError> {
        let word = self.quoted(expected)?;
        let place = || self.place(word.line);
        limits::check(word.text.len(), MAX_NAME, "the length of a name", place)?;
        Ok(word.text.to_owned())
    }

    /// Numbers of a directive, in brackets or not.
    pub(super) fn numbers<const N: usize>(&mut self, of: &str) -> Result<[f64; N], LoadError> {
        let in_brackets = self.peek().is_some_and(|word| word.is_bracket("["));
        if in_brackets {
            self.next();
        }
        let expected = format!("{N} numbers ({of})");
        let mut values = [0.0; N];
        for value in &mut values {
            let word = self.any(&expected)?;
            let place = || self.place(word.line);
            let Some(number) = word.number() else {
                return Err(LoadError::syntax(place(), word.text, expected));
            };
            *value = coordinate(number, of, place)?;
        }
        if in_brackets {
            let word = self.any("]")?;
            if !word.is_bracket("]") {
                return Err(LoadError::syntax(self.place(word.line), word.text, "]"));
            }
        }
        Ok(values)
    }

    /// Leaves out what belongs to a directive.
    pub(super) fn pass_over(&mut self) {
        while self.peek().is_some_and(|word| !word.is_directive()) {
            self.next();
        }
    }
}
