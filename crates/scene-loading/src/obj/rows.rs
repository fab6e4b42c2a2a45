//! Rows of an OBJ file: where they end, their words, and the numbers in them.

use glam::DVec3;
use memchr::memchr;

use crate::error::{FilePlace, LoadError};
use crate::input::parse_number;
use crate::mesh::MAX_COORDINATE;

/// A row of the file, which may go on over several lines.
pub(super) struct Row {
    /// Its end: the last line break, or the end of the file.
    pub end: usize,
    /// Line breaks it takes with it.
    pub newlines: usize,
    /// It ends in a `\` that does not continue it.
    pub is_kept_apart: bool,
}

/// The row that begins at `start`. A line that ends in `\`, with or without blanks behind it, is
/// joined with the next by blanks; but a comment ends with its line, and so does a name, which is
/// more often a Windows path than one that goes on.
pub(super) fn row_at(text: &mut [u8], start: usize) -> Row {
    let mut newlines = 1;
    let mut from = start;
    loop {
        let rest = text.get(from..).unwrap_or_default();
        let Some(length) = memchr(b'\n', rest) else {
            return Row { end: text.len(), newlines, is_kept_apart: false };
        };
        let end = from + length;
        let line = rest.get(..length).unwrap_or_default().trim_ascii_end();
        if line.last() != Some(&b'\\') {
            return Row { end, newlines, is_kept_apart: false };
        }
        if has_comment(line) || (from == start && is_name(line)) {
            return Row { end, newlines, is_kept_apart: true };
        }
        if let Some(joint) = text.get_mut(from + line.len() - 1..=end) {
            joint.fill(b' ');
        }
        newlines += 1;
        from = end + 1;
    }
}

/// True when a word of the line begins a comment.
fn has_comment(line: &[u8]) -> bool {
    line.first() == Some(&b'#')
        || line.windows(2).any(|pair| matches!(pair, [blank, b'#'] if blank.is_ascii_whitespace()))
}

fn is_name(line: &[u8]) -> bool {
    let line = line.trim_ascii_start();
    let keyword = line.split(u8::is_ascii_whitespace).next().unwrap_or_default();
    matches!(keyword, b"g" | b"o" | b"usemtl" | b"mtllib" | b"usemap" | b"maplib")
}

/// The words of a row, up to a `#`.
pub(super) fn words(row: &[u8]) -> impl Iterator<Item = &str> {
    let mut rest = row;
    std::iter::from_fn(move || {
        rest = rest.trim_ascii_start();
        let length = rest.iter().take_while(|b| !b.is_ascii_whitespace()).count();
        let (word, after) = rest.split_at(length);
        rest = after;
        let word = std::str::from_utf8(word).unwrap_or("\u{fffd}");
        (!word.is_empty() && !word.starts_with('#')).then_some(word)
    })
}

/// The position of a vertex that no face can use.
pub(super) const UNUSABLE: DVec3 = DVec3::NAN;

/// Reads the arguments of `v`: x y z, then nothing, w (a divisor) or a colour (dropped).
/// [`UNUSABLE`] if a number is NaN, infinite or too large.
pub(super) fn position(row: &[u8], place: impl Fn() -> FilePlace) -> Result<DVec3, LoadError> {
    let mut words = words(row);
    let mut xyz = [0.0; 3];
    for (i, value) in xyz.iter_mut().enumerate() {
        let Some(word) = words.next() else {
            let found = format!("{i} numbers");
            return Err(LoadError::syntax(place(), &found, "3 (vertex position)"));
        };
        *value = number(word, "vertex position", &place)?;
    }
    let xyz = DVec3::from_array(xyz);
    let xyz = match (words.next(), words.next()) {
        (Some(word), None) => {
            let w = number(word, "vertex weight w", &place)?;
            let is_usable = (1e-100..=1e100).contains(&w.abs());
            if is_usable { xyz / w } else { UNUSABLE }
        }
        _ => xyz,
    };
    Ok(if is_usable(xyz) { xyz } else { UNUSABLE })
}

/// True when nothing of a vector is NaN, infinite or too large to be worked with.
fn is_usable(v: DVec3) -> bool {
    v.abs().cmple(DVec3::splat(MAX_COORDINATE)).all()
}

/// Reads the arguments of `vn`; `None` if they are no normal.
pub(super) fn normal(row: &[u8]) -> Option<DVec3> {
    let mut numbers = words(row).map(|word| word.parse().ok());
    let normal = DVec3::new(numbers.next()??, numbers.next()??, numbers.next()??);
    is_usable(normal).then_some(normal)
}

/// Reads the arguments of `vt`: u, and v or 0; w is dropped. `None` if it is no position in an
/// image.
pub(super) fn texture_coordinate(row: &[u8]) -> Option<[f32; 2]> {
    let mut numbers = words(row).map(|word| word.parse::<f64>().ok());
    let exact = [numbers.next()??, numbers.next().unwrap_or(Some(0.0))?];
    // beyond f32, infinity would be a texel of its own
    exact
        .iter()
        .all(|value| value.is_finite())
        .then(|| exact.map(|value| (value as f32).clamp(f32::MIN, f32::MAX)))
}

fn number(word: &str, what: &str, place: impl Fn() -> FilePlace) -> Result<f64, LoadError> {
    parse_number(word).ok_or_else(|| LoadError::syntax(place(), word, format!("a number ({what})")))
}
