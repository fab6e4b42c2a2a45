//! The numbers after a PLY header, one after the other, in text or binary.

use std::path::Path;

use crate::error::{FileLocation, FilePlace, LoadError, shortened};
use crate::input::parse_number;
use crate::ply::header::{Encoding, Scalar};

/// Numbers in the order of the file.
pub(super) trait Values {
    /// The next one; whole numbers up to 2^53 are exact.
    fn next(&mut self, scalar: Scalar, what: &str) -> Result<f64, LoadError>;

    /// Leaves out so many.
    fn skip(&mut self, scalar: Scalar, count: u64, what: &str) -> Result<(), LoadError>;

    /// Position of the next number; skips white space.
    fn place(&mut self) -> FileLocation;

    /// Bytes not yet read.
    fn remaining(&self) -> usize;
}

/// A binary file: places are bytes.
pub(super) struct Binary<'a> {
    pub path: &'a Path,
    pub bytes: &'a [u8],
    pub at: usize,
    pub encoding: Encoding,
}

impl Binary<'_> {
    fn ended(&self, what: &str) -> LoadError {
        LoadError::unexpected_end(FilePlace::byte(self.path, self.at), what)
    }
}

impl Values for Binary<'_> {
    fn next(&mut self, scalar: Scalar, what: &str) -> Result<f64, LoadError> {
        let rest = self.bytes.get(self.at..).unwrap_or_default();
        let is_little = self.encoding == Encoding::LittleEndian;
        let value = scalar.read(rest, is_little).ok_or_else(|| self.ended(what))?;
        self.at += scalar.size();
        Ok(value)
    }

    fn skip(&mut self, scalar: Scalar, count: u64, what: &str) -> Result<(), LoadError> {
        let bytes = count.saturating_mul(scalar.size() as u64);
        if bytes > self.remaining() as u64 {
            return Err(self.ended(what));
        }
        self.at += usize::try_from(bytes).unwrap_or(usize::MAX);
        Ok(())
    }

    fn place(&mut self) -> FileLocation {
        FileLocation::Byte(self.at)
    }

    fn remaining(&self) -> usize {
        self.bytes.len().saturating_sub(self.at)
    }
}

/// A text: places are lines. Line breaks count as any other white space.
pub(super) struct Text<'a> {
    pub path: &'a Path,
    pub bytes: &'a [u8],
    pub at: usize,
    pub line: usize,
}

impl<'a> Text<'a> {
    /// The rest, from the next word on.
    fn rest(&mut self) -> &'a [u8] {
        let mut rest = self.bytes.get(self.at..).unwrap_or_default();
        while let [first, more @ ..] = rest
            && first.is_ascii_whitespace()
        {
            // a line ends in LF, CR LF or CR
            let ends = *first == b'\n' || (*first == b'\r' && more.first() != Some(&b'\n'));
            self.line += usize::from(ends);
            rest = more;
        }
        self.at = self.bytes.len() - rest.len();
        rest
    }

    fn word(&mut self, what: &str) -> Result<&'a str, LoadError> {
        let rest = self.rest();
        let length = rest.iter().take_while(|byte| !byte.is_ascii_whitespace()).count();
        let word = rest.get(..length).unwrap_or_default();
        self.at += length;
        if word.is_empty() {
            return Err(LoadError::unexpected_end(FilePlace::line(self.path, self.line), what));
        }
        Ok(std::str::from_utf8(word).unwrap_or("\u{fffd}"))
    }
}

impl Values for Text<'_> {
    fn next(&mut self, scalar: Scalar, what: &str) -> Result<f64, LoadError> {
        let word = self.word(what)?;
        let value = parse_number(word);
        // some writers give whole numbers as 3.0
        match value.filter(|value| !scalar.is_integer() || value.fract() == 0.0) {
            Some(value) => Ok(value),
            None => {
                let number = if scalar.is_integer() { "a whole number" } else { "a number" };
                let (found, expected) = (shortened(word), format!("{number} ({what})"));
                Err(LoadError::syntax(FilePlace::line(self.path, self.line), &found, expected))
            }
        }
    }

    fn skip(&mut self, _: Scalar, count: u64, what: &str) -> Result<(), LoadError> {
        (0..count).try_for_each(|_| self.word(what).map(|_| ()))
    }

    fn place(&mut self) -> FileLocation {
        self.rest();
        FileLocation::Line(self.line)
    }

    fn remaining(&self) -> usize {
        self.bytes.len().saturating_sub(self.at)
    }
}
