//! Binary STL files: 80 bytes of free text, the number of triangles, and 50 bytes for each.

use std::path::Path;

use crate::error::{FilePlace, LoadError};
use crate::input::text::without_mark;
use crate::limits;
use crate::progress;
use crate::stl::reader::Reader;

/// Bytes before the first triangle: a free text, then the number of triangles.
const HEADER: usize = 84;

/// Bytes of a triangle: normal and corners as 12 f32, then two of attributes.
const TRIANGLE: usize = 50;

/// Zero bytes before this place make a file binary.
const NEAR_START: usize = 512;

/// Progress is told once for so many triangles.
const TOLD_EVERY: usize = 1 << 16;

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
pub(super) fn is_binary(path: &Path, bytes: &[u8]) -> Result<bool, LoadError> {
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

impl Reader<'_> {
    pub(super) fn binary(&mut self, bytes: &[u8]) -> Result<(), LoadError> {
        let path = self.path;
        let place = |at| FilePlace::byte(path, at);
        let Some(stated) = stated(bytes) else {
            let expected = "`solid`, or 80 bytes and the number of triangles".to_owned();
            return Err(LoadError::UnexpectedEnd { place: place(bytes.len()), expected });
        };
        let data = bytes.get(HEADER..).unwrap_or_default();
        let fits = data.len() / TRIANGLE;
        let mut count = usize::try_from(stated).unwrap_or(usize::MAX);
        if NOT_KNOWN.contains(&stated) && count != fits {
            self.warn(format!(
                "the number of triangles says {stated}; the file's length says {fits} (byte {})",
                HEADER - 4
            ));
            count = fits;
        }
        limits::check(count, fits, "the number of triangles", || place(HEADER - 4))?;
        let payload = Payload::of(data, count);
        if payload.end != data.len() && payload.is_there {
            let found = format!("{} bytes for {count} triangles", data.len());
            let expected = format!(
                "50 a triangle, or as many more as the attributes of each say ({} in all)",
                payload.end
            );
            return Err(LoadError::syntax(place(HEADER - 4), &found, expected));
        }
        if payload.is_there {
            let more = payload.end - count * TRIANGLE;
            self.warn(format!("{more} bytes of attributes behind triangles left out"));
        } else if data.len() > count * TRIANGLE {
            let (left, end) = (data.len() - count * TRIANGLE, HEADER + count * TRIANGLE);
            self.warn(format!("{left} bytes after the last triangle left out (byte {end})"));
        }
        progress::begin(count);
        let mut at = 0;
        for i in 0..count {
            if i % TOLD_EVERY == 0 {
                progress::at(i);
            }
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
            at += TRIANGLE + if payload.is_there { length_of(attributes) } else { 0 };
        }
        Ok(())
    }
}

/// Data that stands behind triangles, as long as the attribute bytes of each say. Most writers keep
/// a colour in those bytes and have none.
struct Payload {
    is_there: bool,
    /// Where the last triangle ends, with its payload.
    end: usize,
}

impl Payload {
    /// The attributes lead from triangle to triangle through the data, and there is any.
    fn of(data: &[u8], count: usize) -> Self {
        let mut end = 0;
        let none = Self { is_there: false, end: data.len() };
        if data.len() == count * TRIANGLE {
            return none;
        }
        for _ in 0..count {
            let record = data.get(end..).and_then(|rest| rest.first_chunk::<TRIANGLE>());
            let Some([.., a, b]) = record else { return none };
            end += TRIANGLE + length_of(&[*a, *b]);
        }
        if end > data.len() { none } else { Self { is_there: end > count * TRIANGLE, end } }
    }
}

fn length_of(attributes: &[u8]) -> usize {
    attributes.first_chunk().map_or(0, |&bytes| u16::from_le_bytes(bytes).into())
}
