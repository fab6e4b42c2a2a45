//! The first pass over an OBJ file: every line is checked, and what a scene needs is taken out.
//!
//! Errors name their lines; `\` continues a line; an index may only mean what is defined before it.
//! What is kept is small (a face takes 12 bytes and 4 to 12 a corner), so that the text can be
//! dropped before the scene is made: files have tens of millions of faces.

use std::collections::{HashMap, HashSet};
use std::path::Path;

use glam::DVec3;
use memchr::{memchr, memmem};

use crate::error::{FilePlace, LoadError, quote, shortened};
use crate::limits::{self, MAX_ELEMENTS, MAX_MATERIALS, MAX_NAME};
use crate::polygon::ear_clipping::MAX_CORNERS;
use crate::progress;

/// Coordinates above this cannot be worked with: their cubes must stay finite.
const MAX_COORDINATE: f64 = 1e100;

/// The most material files of one OBJ file.
const MAX_LIBRARIES: usize = 256;

/// Progress is told, and what a file holds compared with its limits, once for so many bytes.
const TOLD_EVERY: usize = 1 << 20;

/// What the first pass learns.
#[derive(Debug, Default)]
pub(crate) struct ObjScan {
    /// Every `v`, divided by its weight.
    pub positions: Vec<DVec3>,
    /// Every `vn`.
    pub normals: Vec<DVec3>,
    /// The faces in file order.
    pub faces: Vec<FaceLine>,
    /// For each corner of each face the index of its position, counted from 0.
    pub corners: Vec<u32>,
    /// The same for normals, or [`NONE`]; empty in files without `vn`.
    pub normal_corners: Vec<u32>,
    /// Texture coordinates in file order, with (0, 0) at the lower left; empty in files without
    /// `mtllib`, which cannot have textures.
    pub texcoords: Vec<[f32; 2]>,
    /// For each corner the index of its texture coordinates, or [`NONE`]; empty where `texcoords`
    /// is.
    pub texcoord_corners: Vec<u32>,
    /// Every file that a `mtllib` names, once, with its first line.
    pub libraries: Vec<(usize, String)>,
    /// Every material name of a `usemtl`, with the line of its first use, in that order.
    pub used: Vec<(usize, String)>,
    /// Every `usemtl`: how many faces come before it, and which of `used` it names.
    pub switches: Vec<(usize, usize)>,
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

/// A corner without normal or texture coordinates.
pub(crate) const NONE: u32 = u32::MAX;

/// Where a face stands, its number of corners, and whether each of them has a normal.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FaceLine {
    pub line: u32,
    pub corners: u32,
    pub smooth: bool,
}

/// Which lists of corners a file can fill.
#[derive(Clone, Copy)]
struct Wanted {
    normals: bool,
    texcoords: bool,
}

pub(crate) fn scan(path: &Path, mut text: Vec<u8>) -> Result<ObjScan, LoadError> {
    if text.starts_with(b"\xff\xfe") || text.starts_with(b"\xfe\xff") {
        let expected = "UTF-8, or any text whose first 128 characters are ASCII's";
        return Err(LoadError::syntax(FilePlace::line(path, 1), "UTF-16 text", expected));
    }
    let mut scan = ObjScan::default();
    let mut names: HashMap<Vec<u8>, usize> = HashMap::new();
    let mut libraries: HashSet<Vec<u8>> = HashSet::new();
    let wanted = Wanted {
        normals: memmem::find(&text, b"vn").is_some(),
        texcoords: memmem::find(&text, b"mtllib").is_some(),
    };
    let mut texcoords = 0;
    let (mut start, mut line, mut told) = (0, 1, 0);
    progress::begin(text.len());
    if text.starts_with(b"\xef\xbb\xbf") {
        // a byte order mark is no part of the first word
        start = 3;
    }
    while start < text.len() {
        if start >= told {
            progress::at(start);
            told = start + TOLD_EVERY;
            scan.check_size(|| FilePlace::line(path, line))?;
        }
        let (end, newlines) = logical_line(&mut text, start);
        let place = || FilePlace::line(path, line);
        let row = text.get(start..end).unwrap_or_default().trim_ascii_start();
        let length = row.iter().take_while(|b| !b.is_ascii_whitespace()).count();
        let (keyword, rest) = row.split_at(length);
        match keyword {
            b"v" => scan.positions.push(position(rest, place)?),
            b"vn" => scan.normals.push(numbers(rest, "normal", place)?.into()),
            b"vt" => {
                let texcoord = texture_coordinate(rest, place)?;
                if wanted.texcoords {
                    scan.texcoords.push(texcoord);
                }
                texcoords += 1;
            }
            b"f" => {
                let (corners, smooth) = face(rest, &mut scan, texcoords, wanted, place)?;
                let line = u32::try_from(line).unwrap_or(u32::MAX);
                scan.faces.push(FaceLine { line, corners, smooth });
            }
            b"usemtl" => {
                let name = rest.trim_ascii();
                if name.is_empty() {
                    return Err(LoadError::syntax(place(), "usemtl", "the name of a material"));
                }
                let index = match names.get(name) {
                    Some(&known) => known,
                    None => {
                        check_name(name, place)?;
                        let count = names.len() + 1;
                        limits::check(count, MAX_MATERIALS, "the number of materials", place)?;
                        names.insert(name.to_vec(), scan.used.len());
                        scan.used.push((line, String::from_utf8_lossy(name).into_owned()));
                        scan.used.len() - 1
                    }
                };
                scan.switches.push((scan.faces.len(), index));
            }
            b"mtllib" => {
                let name = rest.trim_ascii();
                if name.is_empty() {
                    return Err(LoadError::syntax(place(), "mtllib", "the name of a file"));
                }
                if !libraries.contains(name) {
                    check_name(name, place)?;
                    let count = libraries.len() + 1;
                    limits::check(count, MAX_LIBRARIES, "the number of material files", place)?;
                    libraries.insert(name.to_vec());
                    scan.libraries.push((line, String::from_utf8_lossy(name).into_owned()));
                }
            }
            b"l" => scan.lines += 1,
            b"p" => scan.points += 1,
            b"curv" | b"curv2" | b"surf" => scan.curves += 1,
            b"" => {}
            other if is_harmless(other) => {}
            other => {
                scan.unknown += 1;
                let start = other.get(..MAX_NAME).unwrap_or(other);
                let word = || quote(&String::from_utf8_lossy(start));
                scan.first_unknown.get_or_insert_with(|| (line, word()));
            }
        }
        start = end + 1;
        line += newlines;
    }
    progress::end();
    scan.check_size(|| FilePlace::line(path, line))?;
    Ok(scan)
}

impl ObjScan {
    /// Refuses what is larger than any scene may be.
    fn check_size(&self, place: impl Fn() -> FilePlace) -> Result<(), LoadError> {
        for (count, what) in [
            (self.positions.len(), "the number of vertices"),
            (self.normals.len(), "the number of normals"),
            (self.texcoords.len(), "the number of texture coordinates"),
            (self.faces.len(), "the number of faces"),
            (self.corners.len() / 4, "a fourth of the corners of all faces"),
            (self.switches.len(), "the number of usemtl lines"),
        ] {
            limits::check(count, MAX_ELEMENTS, what, &place)?;
        }
        Ok(())
    }
}

fn check_name(name: &[u8], place: impl Fn() -> FilePlace) -> Result<(), LoadError> {
    limits::check(name.len(), MAX_NAME, "the length of a name", place)
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

/// The words of a row, up to a `#`.
fn words(row: &[u8]) -> impl Iterator<Item = &str> {
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

/// A finite number, or an error that names what it should be and where.
pub(crate) fn number(
    word: &str,
    what: &str,
    place: impl Fn() -> FilePlace,
) -> Result<f64, LoadError> {
    let value: f64 =
        word.parse().map_err(|_| LoadError::syntax(place(), word, format!("a number ({what})")))?;
    if !value.is_finite() {
        let (what, found) = (what.to_string(), shortened(word));
        return Err(LoadError::NotFinite { place: place(), what, found });
    }
    Ok(value)
}

/// The first numbers of a row, as many as are asked for, of a size that can be worked with.
fn numbers<const N: usize>(
    row: &[u8],
    what: &str,
    place: impl Fn() -> FilePlace,
) -> Result<[f64; N], LoadError> {
    let mut words = words(row);
    let mut values = [0.0; N];
    for (i, value) in values.iter_mut().enumerate() {
        let Some(word) = words.next() else {
            let found = format!("{i} numbers");
            return Err(LoadError::syntax(place(), &found, format!("{N} ({what})")));
        };
        *value = number(word, what, &place)?;
        if value.abs() > MAX_COORDINATE {
            return Err(LoadError::OutOfRange {
                place: place(),
                what: what.to_string(),
                found: shortened(word),
                expected: format!("at most {MAX_COORDINATE:e} in size"),
            });
        }
    }
    Ok(values)
}

/// A `v` line: x y z, then nothing, or w (by which they are divided), or a colour (dropped).
fn position(row: &[u8], place: impl Fn() -> FilePlace) -> Result<DVec3, LoadError> {
    let what = "vertex position";
    let xyz = DVec3::from_array(numbers(row, what, &place)?);
    let mut extra = words(row).skip(3);
    let (Some(word), None) = (extra.next(), extra.next()) else { return Ok(xyz) };
    let w = number(word, "vertex weight w", &place)?;
    if !(1e-100..=1e100).contains(&w.abs()) || (xyz / w).abs().max_element() > MAX_COORDINATE {
        return Err(LoadError::OutOfRange {
            place: place(),
            what: "vertex weight w".into(),
            found: shortened(word),
            expected: "neither 0 nor extreme".into(),
        });
    }
    Ok(xyz / w)
}

/// A `vt` line: u, and v where it is there, else 0; w is dropped.
fn texture_coordinate(row: &[u8], place: impl Fn() -> FilePlace) -> Result<[f32; 2], LoadError> {
    numbers::<1>(row, "texture coordinate", &place)?;
    let mut values = [0.0; 2];
    for (value, word) in values.iter_mut().zip(words(row)) {
        let exact = number(word, "texture coordinate", &place)?;
        // beyond f32, infinity would be a texel of its own
        *value = (exact as f32).clamp(f32::MIN, f32::MAX);
    }
    Ok(values)
}

/// Takes the corners of a face, whose indices are checked; returns their number and whether all of
/// them have a normal.
fn face(
    row: &[u8],
    scan: &mut ObjScan,
    texcoords: usize,
    wanted: Wanted,
    place: impl Fn() -> FilePlace,
) -> Result<(u32, bool), LoadError> {
    let (positions, normals) = (scan.positions.len(), scan.normals.len());
    let (mut corners, mut smooth) = (0, true);
    for corner in words(row) {
        let bad = || LoadError::syntax(place(), corner, "a corner: v, v/vt, v//vn or v/vt/vn");
        let mut parts = corner.split('/');
        let index = |part: Option<&str>, what, count| match part {
            None | Some("") => Ok(None),
            Some(text) => check_index(text, what, count, &place).map(Some),
        };
        let position = index(parts.next(), "vertex", positions)?.ok_or_else(bad)?;
        let texcoord = index(parts.next(), "texture coordinate", texcoords)?;
        let normal = index(parts.next(), "normal", normals)?;
        if parts.next().is_some() {
            return Err(bad());
        }
        // Files end at 2 GiB, so that their lists stay within u32.
        let index = |i: usize| u32::try_from(i).unwrap_or(NONE);
        scan.corners.push(index(position));
        if wanted.normals {
            scan.normal_corners.push(normal.map_or(NONE, index));
        }
        if wanted.texcoords {
            scan.texcoord_corners.push(texcoord.map_or(NONE, index));
        }
        smooth &= normal.is_some();
        corners += 1;
        if corners as usize > MAX_CORNERS {
            limits::check(
                corners as usize,
                MAX_CORNERS,
                "the number of corners of a face",
                &place,
            )?;
        }
    }
    if corners < 3 {
        let found = format!("a face with {corners} corners");
        return Err(LoadError::syntax(place(), &found, "at least 3"));
    }
    Ok((corners, smooth))
}

/// Indices count from 1, or backwards from -1; only what is already defined can be meant. Returns
/// the index counted from 0.
fn check_index(
    text: &str,
    what: &str,
    count: usize,
    place: impl Fn() -> FilePlace,
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
            index: shortened(text),
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
