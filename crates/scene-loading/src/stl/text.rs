//! STL files as text: `solid NAME`, facets, `endsolid NAME`; several such parts. All white space is
//! alike, so that a whole file may stand on one line.

use crate::error::{FilePlace, LoadError};
use crate::input::text::parse_number;
use crate::nff::tokens::Words;
use crate::progress;
use crate::stl::reader::Reader;

impl Reader<'_> {
    pub(super) fn text(&mut self, text: &str) -> Result<(), LoadError> {
        let mut words = Words::new(self.path, text);
        progress::begin(text.len());
        let mut told = 0;
        let mut is_open = false;
        while let Some(word) = words.next() {
            let left = words.remaining();
            if text.len() - left >= told {
                progress::at(text.len() - left);
                told = text.len() - left + (1 << 20);
            }
            match word.text.to_ascii_lowercase().as_str() {
                "facet" => self.facet(&mut words, word.line)?,
                "solid" => {
                    is_open = true;
                    skip_name(&mut words, word.line);
                }
                "endsolid" => {
                    is_open = false;
                    skip_name(&mut words, word.line);
                }
                "end" if words.peek().is_some_and(|next| is(next.text, "solid")) => {
                    is_open = false;
                    skip_name(&mut words, word.line);
                }
                _ => {
                    let place = words.place(word.line);
                    return Err(LoadError::syntax(place, word.text, "facet, solid or endsolid"));
                }
            }
        }
        if is_open {
            self.warn("`endsolid` is missing: is the file cut off?".into());
        }
        Ok(())
    }

    fn facet(&mut self, words: &mut Words<'_>, line: usize) -> Result<(), LoadError> {
        keyword(words, "normal")?;
        // some writers have nan here; it is not used
        for _ in 0..3 {
            words.any("a component of the normal")?;
        }
        keyword(words, "outer")?;
        keyword(words, "loop")?;
        let mut corners = [[0.0; 3]; 3];
        for corner in &mut corners {
            keyword(words, "vertex")?;
            for value in corner {
                let word = words.any("vertex position")?;
                *value = parse_number(word.text).ok_or_else(|| {
                    let place = words.place(word.line);
                    LoadError::syntax(place, word.text, "a number (vertex position)")
                })?;
            }
        }
        end(words, "endloop")?;
        end(words, "endfacet")?;
        let path = self.path;
        self.add(corners, || FilePlace::line(path, line))
    }
}

fn is(word: &str, expected: &str) -> bool {
    word.eq_ignore_ascii_case(expected)
}

/// Passes over the name of a part: what is left of the line, up to a first facet.
fn skip_name(words: &mut Words<'_>, line: usize) {
    while words.peek().is_some_and(|word| word.line == line) && !words.are_next(["facet", "normal"])
    {
        words.next();
    }
}

/// Takes a word that must be this one, in any case.
fn keyword(words: &mut Words<'_>, expected: &str) -> Result<(), LoadError> {
    let word = words.any(expected)?;
    if is(word.text, expected) {
        return Ok(());
    }
    Err(LoadError::syntax(words.place(word.line), word.text, expected))
}

/// As [`keyword`]; some writers have two words, `end loop`.
fn end(words: &mut Words<'_>, expected: &str) -> Result<(), LoadError> {
    if words.peek().is_some_and(|word| is(word.text, "end")) {
        words.next();
        return keyword(words, expected.strip_prefix("end").unwrap_or(expected));
    }
    keyword(words, expected)
}
