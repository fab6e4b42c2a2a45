//! Words, quoted strings and brackets of a PBRT file, with their lines.

use std::path::Path;

use crate::error::{FilePlace, LoadError};
use crate::limits::{self, MAX_NAME};
use crate::mesh::coordinate;

/// Kind of a token.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    /// A directive, a number, `true` or `false`.
    Word,
    Quoted,
    Open,
    Close,
}

#[derive(Debug, Clone, Copy)]
pub(super) struct Token<'a> {
    pub kind: Kind,
    pub text: &'a str,
    pub line: usize,
}

impl Token<'_> {
    pub fn number(self) -> Option<f64> {
        if self.kind == Kind::Word { self.text.parse().ok() } else { None }
    }

    /// A word that begins a new statement.
    pub fn is_directive(self) -> bool {
        self.kind == Kind::Word
            && !matches!(self.text, "true" | "false")
            && self.number().is_none()
            && self.text.starts_with(|c: char| c.is_ascii_alphabetic())
    }
}

/// The tokens of a text; `#` begins a comment.
pub(super) struct Tokens<'a> {
    pub path: &'a Path,
    rest: &'a str,
    line: usize,
    peeked: Option<Token<'a>>,
}

impl<'a> Tokens<'a> {
    pub fn new(path: &'a Path, text: &'a str) -> Self {
        Self { path, rest: text, line: 1, peeked: None }
    }

    pub fn place(&self, line: usize) -> FilePlace {
        FilePlace::line(self.path, line)
    }

    /// Bytes not yet read.
    pub fn remaining(&self) -> usize {
        self.rest.len()
    }

    /// The next token, left in place.
    ///
    /// # Errors
    /// [`LoadError::UnexpectedEnd`] for a quote that is not closed.
    pub fn peek(&mut self) -> Result<Option<Token<'a>>, LoadError> {
        if self.peeked.is_none() {
            self.peeked = self.read()?;
        }
        Ok(self.peeked)
    }

    /// Takes the next token.
    ///
    /// # Errors
    /// As [`Tokens::peek`].
    pub fn next(&mut self) -> Result<Option<Token<'a>>, LoadError> {
        let token = self.peek()?;
        self.peeked = None;
        Ok(token)
    }

    /// The next token, which must be there.
    pub fn expect(&mut self, expected: &str) -> Result<Token<'a>, LoadError> {
        self.next()?.ok_or_else(|| LoadError::unexpected_end(self.place(self.line), expected))
    }

    /// The next token, which must be a quoted string.
    pub fn quoted(&mut self, expected: &str) -> Result<Token<'a>, LoadError> {
        let token = self.expect(expected)?;
        if token.kind == Kind::Quoted {
            return Ok(token);
        }
        Err(LoadError::syntax(self.place(token.line), token.text, format!("\"{expected}\"")))
    }

    /// A quoted string of a length that names may have.
    ///
    /// # Errors
    /// As [`Tokens::quoted`], and [`LoadError::CountTooLarge`].
    pub fn name(&mut self, expected: &str) -> Result<String, LoadError> {
        let token = self.quoted(expected)?;
        let place = || self.place(token.line);
        limits::check(token.text.len(), MAX_NAME, "the length of a name", place)?;
        Ok(token.text.to_owned())
    }

    /// Numbers of a directive, in brackets or not.
    ///
    /// # Errors
    /// [`LoadError::Syntax`], [`LoadError::UnexpectedEnd`], [`LoadError::NotFinite`],
    /// [`LoadError::OutOfRange`].
    pub fn numbers<const N: usize>(&mut self, of: &str) -> Result<[f64; N], LoadError> {
        let in_brackets = self.peek()?.is_some_and(|token| token.kind == Kind::Open);
        if in_brackets {
            self.next()?;
        }
        let expected = format!("{N} numbers ({of})");
        let mut values = [0.0; N];
        for value in &mut values {
            let token = self.expect(&expected)?;
            let place = || self.place(token.line);
            let Some(number) = token.number() else {
                return Err(LoadError::syntax(place(), token.text, expected));
            };
            *value = coordinate(number, of, place)?;
        }
        if in_brackets {
            let token = self.expect("]")?;
            if token.kind != Kind::Close {
                return Err(LoadError::syntax(self.place(token.line), token.text, "]"));
            }
        }
        Ok(values)
    }

    /// Leaves out what belongs to a directive.
    ///
    /// # Errors
    /// As [`Tokens::peek`].
    pub fn pass_over(&mut self) -> Result<(), LoadError> {
        while self.peek()?.is_some_and(|token| !token.is_directive()) {
            self.next()?;
        }
        Ok(())
    }

    fn take(&mut self, length: usize) -> &'a str {
        let (taken, rest) = self.rest.split_at_checked(length).unwrap_or((self.rest, ""));
        self.rest = rest;
        taken
    }

    fn read(&mut self) -> Result<Option<Token<'a>>, LoadError> {
        loop {
            let text = self.rest.trim_ascii_start();
            let blank = self.take(self.rest.len() - text.len());
            self.line += blank.bytes().filter(|&byte| byte == b'\n').count();
            if !self.rest.starts_with('#') {
                break;
            }
            self.take(self.rest.find('\n').unwrap_or(self.rest.len()));
        }
        let line = self.line;
        let Some(first) = self.rest.bytes().next() else { return Ok(None) };
        let (kind, text) = match first {
            b'[' => (Kind::Open, self.take(1)),
            b']' => (Kind::Close, self.take(1)),
            b'"' => {
                self.take(1);
                let Some(length) = self.rest.find(['"', '\n']) else {
                    return Err(self.unclosed());
                };
                let text = self.take(length);
                if self.take(1) != "\"" {
                    return Err(self.unclosed());
                }
                (Kind::Quoted, text)
            }
            _ => {
                let ends = |c: char| c.is_ascii_whitespace() || matches!(c, '[' | ']' | '"' | '#');
                let length = self.rest.find(ends).unwrap_or(self.rest.len());
                (Kind::Word, self.take(length))
            }
        };
        Ok(Some(Token { kind, text, line }))
    }

    fn unclosed(&self) -> LoadError {
        LoadError::unexpected_end(self.place(self.line), "the end of a quoted string")
    }
}
