//! Stereolithography files, STL (3D Systems, "StereoLithography Interface Specification", 1989),
//! text and binary.
//!
//! A file is binary when its length is what the number at byte 80 says, when it begins neither with
//! `solid` nor has a `facet` near its start, or when zero bytes stand there: binary files that
//! begin with `solid` are common. Normals are those of the corners' order, colours in the attribute
//! bytes are left out, and corners in the same place become one vertex. Triangles with a corner
//! that is NaN are left out.

use std::path::Path;

use crate::error::{FilePlace, LoadError};
use crate::input::{parse_number, text_of, without_mark};
use crate::limits;
use crate::mesh::{TriangleList, is_usable};
use crate::progress;
use crate::scene::Scene;
use crate::words::Words;

/// Parses an STL file. `path` gives the scene its name and appears in errors, with the line or the
/// byte. Scenes have no lights, one material, and a camera that frames them.
///
/// # Errors
/// [`LoadError::Syntax`], [`LoadError::UnexpectedEnd`], [`LoadError::CountTooLarge`],
/// [`LoadError::NoPrimitives`].
pub fn parse_stl(path: &Path, bytes: Vec<u8>) -> Result<Scene, LoadError> {
    let mut reader = Reader { path, triangles: TriangleList::new(path) };
    if is_binary(path, &bytes)? {
        reader.binary(&bytes)?
    } else {
        reader.text(&text_of(path, bytes)?)?
    }
    progress::end();
    reader.triangles.finish(path)
}

struct Reader<'a> {
    path: &'a Path,
    triangles: TriangleList,
}

impl Reader<'_> {
    fn add(
        &mut self,
        corners: [[f64; 3]; 3],
        place: impl Fn() -> FilePlace,
    ) -> Result<(), LoadError> {
        if !corners.as_flattened().iter().all(|&value| is_usable(value)) {
            self.triangles.counts.unusable.add(place);
            return Ok(());
        }
        self.triangles.add(corners, place)
    }

    fn warn(&mut self, text: String) {
        self.triangles.scene.warn(format!("{}: {text}", self.path.display()));
    }

    fn text(&mut self, text: &str) -> Result<(), LoadError> {
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
                solid @ ("solid" | "endsolid") => {
                    is_open = solid == "solid";
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
        words.keyword("normal")?;
        // some writers have nan here; it is not used
        for _ in 0..3 {
            words.any("a component of the normal")?;
        }
        words.keyword("outer")?;
        words.keyword("loop")?;
        let mut corners = [[0.0; 3]; 3];
        for corner in &mut corners {
            words.keyword("vertex")?;
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

    fn binary(&mut self, bytes: &[u8]) -> Result<(), LoadError> {
        let path = self.path;
        let place = |at| FilePlace::byte(path, at);
        let Some(stated) = stated(bytes) else {
            let expected = "`solid`, or 80 bytes and the number of triangles";
            return Err(LoadError::unexpected_end(place(bytes.len()), expected));
        };
        let data = bytes.get(HEADER..).unwrap_or_default();
        let fits = data.len() / TRIANGLE;
        let mut count = usize::try_from(stated).unwrap_or(usize::MAX);
        if NOT_KNOWN.contains(&stated) && count != fits {
            self.warn(format!(
                "the header states {stated} triangles, the file's length fits {fits} (byte {})",
                HEADER - 4
            ));
            count = fits;
        }
        limits::check(count, fits, "the number of triangles", || place(HEADER - 4))?;
        let payload = payload_end(data, count);
        if let Some(end) = payload {
            if end != data.len() {
                let found = format!("{} bytes for {count} triangles", data.len());
                let expected = format!(
                    "50 a triangle, or as many more as the attributes of each say ({end} in all)"
                );
                return Err(LoadError::syntax(place(HEADER - 4), &found, expected));
            }
            let more = end - count * TRIANGLE;
            self.warn(format!("{more} bytes of attributes behind triangles left out"));
        } else if data.len() > count * TRIANGLE {
            let (left, end) = (data.len() - count * TRIANGLE, HEADER + count * TRIANGLE);
            self.warn(format!("{left} bytes after the last triangle left out (byte {end})"));
        }
        progress::begin(count);
        let mut at = 0;
        for i in 0..count {
            progress::step(i);
            let record = data.get(at..).and_then(|rest| rest.first_chunk::<TRIANGLE>());
            let Some(record) = record else { break };
            let (numbers, attributes) = record.as_chunks::<4>();
            let mut corners = [[0.0; 3]; 3];
            // the normal first, which the corners have, too
            let numbers = numbers.iter().skip(3).map(|&b| f64::from(f32::from_le_bytes(b)));
            for (slot, value) in corners.as_flattened_mut().iter_mut().zip(numbers) {
                *slot = value;
            }
            self.add(corners, || place(HEADER + at))?;
            at += TRIANGLE + if payload.is_some() { length_of(attributes) } else { 0 };
        }
        Ok(())
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

/// As [`Words::keyword`]; some writers have two words, `end loop`.
fn end(words: &mut Words<'_>, expected: &str) -> Result<(), LoadError> {
    if words.peek().is_some_and(|word| is(word.text, "end")) {
        words.next();
        return words.keyword(expected.strip_prefix("end").unwrap_or(expected));
    }
    words.keyword(expected)
}

/// Bytes before the first triangle: a free text, then the number of triangles.
const HEADER: usize = 84;

/// Bytes of a triangle: normal and corners as 12 f32, then two of attributes.
const TRIANGLE: usize = 50;

/// Zero bytes before this place make a file binary.
const NEAR_START: usize = 512;

/// Numbers of triangles that a writer which cannot go back in its file leaves where it does not
/// know them yet.
const NOT_KNOWN: [u32; 3] = [0, i32::MAX as u32, u32::MAX];

/// The number of triangles that a file states.
fn stated(bytes: &[u8]) -> Option<u32> {
    let number = bytes.get(HEADER - 4..)?.first_chunk::<4>()?;
    Some(u32::from_le_bytes(*number))
}

/// # Errors
/// [`LoadError::Syntax`] for UTF-16.
fn is_binary(path: &Path, bytes: &[u8]) -> Result<bool, LoadError> {
    let length = |count| HEADER as u64 + TRIANGLE as u64 * u64::from(count);
    if stated(bytes).is_some_and(|count| length(count) == bytes.len() as u64) {
        return Ok(true);
    }
    let text = without_mark(path, bytes)?.trim_ascii_start();
    let near = text.get(..NEAR_START.min(text.len())).unwrap_or_default();
    let begins = |word: &[u8]| near.get(..5).is_some_and(|w| w.eq_ignore_ascii_case(word));
    let is_solid =
        begins(b"solid") || near.to_ascii_lowercase().windows(5).any(|word| word == b"facet");
    Ok(!is_solid || near.contains(&0))
}

/// End of the last triangle with the data behind it, where attribute bytes that give its length
/// lead from triangle to triangle through the file. None where there is no such data: most writers
/// keep a colour in those bytes.
fn payload_end(data: &[u8], count: usize) -> Option<usize> {
    let mut end = 0;
    for _ in 0..count {
        let [.., a, b] = data.get(end..)?.first_chunk::<TRIANGLE>()?;
        end += TRIANGLE + length_of(&[*a, *b]);
    }
    (count * TRIANGLE < end && end <= data.len()).then_some(end)
}

fn length_of(attributes: &[u8]) -> usize {
    attributes.first_chunk().map_or(0, |&bytes| u16::from_le_bytes(bytes).into())
}
