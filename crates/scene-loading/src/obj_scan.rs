//! A scan over the text of an OBJ file before tobj sees it.
//!
//! tobj 4.0 reports errors without lines, accepts `nan` and `1e400`, takes `f 1//9` without a
//! ninth normal, turns polylines into faces, knows no `\` continuations and starts a new vertex
//! list at every `g`. The scan therefore checks each line, and edits the text in place (never
//! changing its length) to the subset of OBJ on which tobj is exact: `v`, `vn`, `f`, `usemtl`.

use std::collections::HashSet;
use std::path::Path;

use memchr::{memchr, memmem};

use crate::error::{LoadError, Place};

/// Coordinates above this cannot be worked with: their cubes must stay finite.
const MAX_COORDINATE: f64 = 1e100;

/// What the scan learns; `faces` has one entry for each face that tobj will return.
#[derive(Debug, Default)]
pub(crate) struct ObjScan {
    /// The cleaned text.
    pub text: Vec<u8>,
    /// The faces in file order.
    pub faces: Vec<FaceLine>,
    /// Texture coordinates in file order, with (0, 0) at the lower left; empty in files without
    /// `mtllib`, which cannot have textures.
    pub texcoords: Vec<[f32; 2]>,
    /// For each corner of each face the index of its texture coordinates, or [`NO_TEXCOORD`];
    /// empty where `texcoords` is.
    pub corners: Vec<u32>,
    /// Every `mtllib` with its line.
    pub libraries: Vec<(usize, String)>,
    /// Every material name of a `usemtl`, with the line of its first use, in that order.
    pub used: Vec<(usize, String)>,
    /// Number of `l` elements.
    pub lines: usize,
    /// Number of `p` elements.
    pub points: usize,
    /// Number of free-form curves and surfaces.
    pub curves: usize,
    /// Number of lines with an unknown keyword, and the first of them.
    pub unknown: usize,
    pub first_unknown: Option<(usize, String)>,
}

/// A corner without texture coordinates.
pub(crate) const NO_TEXCOORD: u32 = u32::MAX;

/// Where a face stands, and whether each of its corners has a normal.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FaceLine {
    pub line: u32,
    pub smooth: bool,
}

/// Counts of elements defined so far: what indices may refer to.
#[derive(Default)]
struct Defined {
    positions: usize,
    texcoords: usize,
    normals: usize,
}

pub(crate) fn scan(path: &Path, text: String) -> Result<ObjScan, LoadError> {
    let mut text = text.into_bytes();
    let mut scan = ObjScan::default();
    let mut seen: HashSet<Vec<u8>> = HashSet::new();
    let mut defined = Defined::default();
    let can_be_textured = memmem::find(&text, b"mtllib").is_some();
    let (mut start, mut line) = (0, 1);
    while start < text.len() {
        let (end, newlines) = logical_line(&mut text, start);
        let place = || Place::line(path, line);
        let Some(row) = text.get_mut(start..end) else { break };
        let indent = row.iter().take_while(|b| b.is_ascii_whitespace()).count();
        let row = row.get_mut(indent..).unwrap_or_default();
        let length = row.iter().take_while(|b| !b.is_ascii_whitespace()).count();
        let (keyword, rest) = row.split_at_mut(length);
        match &*keyword {
            b"v" => {
                position(rest, place)?;
                defined.positions += 1;
            }
            b"vn" => {
                let used = numbers(rest, 3, "normal", place)?;
                blank(rest, used);
                defined.normals += 1;
            }
            b"vt" => {
                let texcoord = texture_coordinate(rest, place)?;
                if can_be_textured {
                    scan.texcoords.push(texcoord);
                }
                defined.texcoords += 1;
                hide(keyword);
            }
            b"f" => {
                let corners = can_be_textured.then_some(&mut scan.corners);
                let smooth = face(rest, &defined, corners, place)?;
                scan.faces.push(FaceLine { line: u32::try_from(line).unwrap_or(u32::MAX), smooth });
            }
            b"usemtl" => {
                let name = rest.trim_ascii().to_vec();
                if name.is_empty() {
                    return Err(LoadError::syntax(place(), "usemtl", "the name of a material"));
                }
                // tobj wants exactly one space, at the start of the line.
                rewrite(rest, &name);
                if let Some(row) = text.get_mut(start..start + indent + length) {
                    row.rotate_left(indent.min(row.len()));
                    let (_, gap) = row.split_at_mut(length.min(row.len()));
                    gap.fill(b' ');
                }
                let text = String::from_utf8_lossy(&name).into_owned();
                if seen.insert(name) {
                    scan.used.push((line, text));
                }
            }
            b"mtllib" => {
                let name = String::from_utf8_lossy(rest.trim_ascii()).into_owned();
                if name.is_empty() {
                    return Err(LoadError::syntax(place(), "mtllib", "the name of a file"));
                }
                scan.libraries.push((line, name));
                hide(keyword);
            }
            b"l" => {
                scan.lines += 1;
                hide(keyword);
            }
            b"p" => {
                scan.points += 1;
                hide(keyword);
            }
            b"curv" | b"curv2" | b"surf" => {
                scan.curves += 1;
                hide(keyword);
            }
            b"" | b"#" => {}
            other => {
                if !is_harmless(other) {
                    scan.unknown += 1;
                    let word = || String::from_utf8_lossy(other).into_owned();
                    scan.first_unknown.get_or_insert_with(|| (line, word()));
                }
                hide(keyword);
            }
        }
        start = end + 1;
        line += newlines;
    }
    scan.text = text;
    Ok(scan)
}

/// The end of the line that begins at `start`, and the number of line breaks it takes with it.
/// Lines that end in `\` are joined with the next by blanks.
fn logical_line(text: &mut [u8], start: usize) -> (usize, usize) {
    let mut newlines = 1;
    let mut from = start;
    loop {
        let rest = text.get(from..).unwrap_or_default();
        let Some(length) = memchr(b'\n', rest) else { return (text.len(), newlines) };
        let end = from + length;
        let row = rest.get(..length).unwrap_or_default();
        let row = row.strip_suffix(b"\r").unwrap_or(row);
        if row.last() != Some(&b'\\') {
            return (end, newlines);
        }
        if let Some(joint) = text.get_mut(from + row.len() - 1..=end) {
            joint.fill(b' ');
        }
        newlines += 1;
        from = end + 1;
    }
}

/// Turns the line into a comment.
fn hide(keyword: &mut [u8]) {
    if let Some(first) = keyword.first_mut() {
        *first = b'#';
    }
}

fn blank(row: &mut [u8], from: usize) {
    row.get_mut(from..).unwrap_or_default().fill(b' ');
}

/// Writes one space and the name over `rest`, and blanks what remains of it.
fn rewrite(rest: &mut [u8], name: &[u8]) {
    blank(rest, 0);
    if let Some(slot) = rest.get_mut(1..=name.len()) {
        slot.copy_from_slice(name);
    }
}

/// The words of a row with the offset just after each, up to a `#`.
fn words(row: &[u8]) -> impl Iterator<Item = (&str, usize)> {
    let mut at = 0;
    std::iter::from_fn(move || {
        let rest = row.get(at..)?;
        let from = at + rest.iter().take_while(|b| b.is_ascii_whitespace()).count();
        let rest = row.get(from..)?;
        let length = rest.iter().take_while(|b| !b.is_ascii_whitespace()).count();
        at = from + length;
        let word = std::str::from_utf8(rest.get(..length)?).unwrap_or("\u{fffd}");
        (!word.is_empty() && !word.starts_with('#')).then_some((word, at))
    })
}

/// A finite number, or an error that names what it should be and where.
pub(crate) fn number(word: &str, what: &str, place: impl Fn() -> Place) -> Result<f64, LoadError> {
    let value: f64 =
        word.parse().map_err(|_| LoadError::syntax(place(), word, format!("a number ({what})")))?;
    if !value.is_finite() {
        let (what, found) = (what.to_string(), word.to_string());
        return Err(LoadError::NotFinite { place: place(), what, found });
    }
    Ok(value)
}

/// Checks that `count` numbers stand there; returns the offset after them.
fn numbers(
    row: &[u8],
    count: usize,
    what: &str,
    place: impl Fn() -> Place,
) -> Result<usize, LoadError> {
    let mut words = words(row);
    let mut after = 0;
    for i in 0..count {
        let Some((word, end)) = words.next() else {
            let found = format!("{i} numbers");
            return Err(LoadError::syntax(place(), &found, format!("{count} ({what})")));
        };
        let value = number(word, what, &place)?;
        if value.abs() > MAX_COORDINATE {
            return Err(LoadError::OutOfRange {
                place: place(),
                what: what.to_string(),
                found: word.to_string(),
                expected: format!("at most {MAX_COORDINATE:e} in size"),
            });
        }
        after = end;
    }
    Ok(after)
}

/// A `v` line: x y z, then nothing, or w (by which tobj divides), or a colour (dropped).
fn position(row: &mut [u8], place: impl Fn() -> Place) -> Result<(), LoadError> {
    let mut after = numbers(row, 3, "vertex position", &place)?;
    let (first, second) = {
        let mut extra = words(row.get(after..).unwrap_or_default());
        (extra.next(), extra.next())
    };
    if let (Some((word, end)), None) = (first, second) {
        let w = number(word, "vertex weight w", &place)?;
        if !(1e-100..=1e100).contains(&w.abs()) {
            return Err(LoadError::OutOfRange {
                place: place(),
                what: "vertex weight w".into(),
                found: word.to_string(),
                expected: "neither 0 nor extreme".into(),
            });
        }
        after += end;
    }
    blank(row, after);
    Ok(())
}

/// A `vt` line: u, and v where it is there, else 0; w is dropped.
fn texture_coordinate(row: &[u8], place: impl Fn() -> Place) -> Result<[f32; 2], LoadError> {
    numbers(row, 1, "texture coordinate", &place)?;
    let mut values = [0.0; 2];
    for (value, (word, _)) in values.iter_mut().zip(words(row)) {
        let exact = number(word, "texture coordinate", &place)?;
        // beyond f32, infinity would be a texel of its own
        *value = (exact as f32).clamp(f32::MIN, f32::MAX);
    }
    Ok(values)
}

/// Checks the corners of a face; true when all of them have a normal. Appends the index of the
/// texture coordinates of each to `texcoords`, where those are wanted.
fn face(
    row: &mut [u8],
    defined: &Defined,
    mut texcoords: Option<&mut Vec<u32>>,
    place: impl Fn() -> Place,
) -> Result<bool, LoadError> {
    let (mut corners, mut smooth, mut after) = (0, true, 0);
    for (corner, end) in words(row) {
        let bad = || LoadError::syntax(place(), corner, "a corner: v, v/vt, v//vn or v/vt/vn");
        let mut parts = corner.split('/');
        let index = |part: Option<&str>, what, count| match part {
            None | Some("") => Ok(None),
            Some(text) => check_index(text, what, count, &place).map(Some),
        };
        if index(parts.next(), "vertex", defined.positions)?.is_none() {
            return Err(bad());
        }
        let texcoord = index(parts.next(), "texture coordinate", defined.texcoords)?;
        if let Some(texcoords) = &mut texcoords {
            texcoords.push(texcoord.and_then(|i| i.try_into().ok()).unwrap_or(NO_TEXCOORD));
        }
        smooth &= index(parts.next(), "normal", defined.normals)?.is_some();
        if parts.next().is_some() {
            return Err(bad());
        }
        corners += 1;
        after = end;
    }
    if corners < 3 {
        let found = format!("a face with {corners} corners");
        return Err(LoadError::syntax(place(), &found, "at least 3"));
    }
    blank(row, after);
    Ok(smooth)
}

/// Indices count from 1, or backwards from -1; only what is already defined can be meant. Returns
/// the index counted from 0.
fn check_index(
    text: &str,
    what: &str,
    count: usize,
    place: impl Fn() -> Place,
) -> Result<usize, LoadError> {
    let is_number =
        text.strip_prefix(['-', '+']).unwrap_or(text).bytes().all(|b| b.is_ascii_digit());
    if !is_number || text.ends_with(['-', '+']) {
        return Err(LoadError::syntax(place(), text, format!("an index ({what})")));
    }
    // Numbers beyond i64 are out of range as well.
    let index = text.parse::<i64>().unwrap_or(0);
    if index == 0 || index.unsigned_abs() > count as u64 {
        let valid = match count {
            0 => format!("the file has no {what} before this line"),
            _ => format!("1 to {count}, or -1 to -{count}, are defined before this line"),
        };
        return Err(LoadError::IndexOutOfRange {
            place: place(),
            what: what.to_string(),
            index: text.to_string(),
            valid,
        });
    }
    let size = usize::try_from(index.unsigned_abs()).unwrap_or(count);
    Ok(if index > 0 { size - 1 } else { count - size })
}

/// Keywords that carry nothing that a scene here could show.
fn is_harmless(keyword: &[u8]) -> bool {
    keyword.starts_with(b"#")
        || matches!(
            keyword,
            b"g" | b"o"
                | b"s"
                | b"mg"
                | b"vp"
                | b"bevel"
                | b"c_interp"
                | b"d_interp"
                | b"lod"
                | b"shadow_obj"
                | b"trace_obj"
                | b"maplib"
                | b"usemap"
                | b"cstype"
                | b"deg"
                | b"bmat"
                | b"step"
                | b"parm"
                | b"trim"
                | b"hole"
                | b"scrv"
                | b"sp"
                | b"end"
                | b"con"
                | b"ctech"
                | b"stech"
        )
}
