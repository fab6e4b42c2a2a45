//! The first pass over an OBJ file: every line is checked, and what a scene needs is taken out.
//!
//! Errors name their lines. What is no geometry is no error: damaged normals and texture
//! coordinates are counted, each kind with its first line. What is kept is small (a face takes 12
//! bytes and 4 to 12 a corner), so that the text can be dropped before the scene is made: files
//! have tens of millions of faces.

use std::collections::HashMap;
use std::path::Path;

use memchr::memmem;

use crate::error::{FilePlace, LoadError, quote};
use crate::input::{end_lines_with_lf, without_mark};
use crate::limits::{self, MAX_ELEMENTS, MAX_MATERIALS, MAX_NAME};
use crate::obj::contents::ObjScan;
use crate::obj::rows::{UNUSABLE, normal, position, row_at, texture_coordinate};
use crate::progress;

/// The most lines with material files of one OBJ file.
pub(super) const MAX_LIBRARIES: usize = 256;

/// Progress is told, and what a file holds compared with its limits, once for so many bytes.
const TOLD_EVERY: usize = 1 << 20;

pub(crate) fn scan(path: &Path, mut text: Vec<u8>) -> Result<ObjScan, LoadError> {
    // a byte order mark is no part of the first word
    let mut start = text.len() - without_mark(path, &text)?.len();
    end_lines_with_lf(&mut text);
    let mut scan = ObjScan {
        keeps_normals: memmem::find(&text, b"vn").is_some(),
        keeps_texcoords: memmem::find(&text, b"mtllib").is_some(),
        ..ObjScan::default()
    };
    let (mut names, mut libraries) = (HashMap::new(), HashMap::new());
    let (mut line, mut told) = (1, 0);
    progress::begin(text.len());
    while start < text.len() {
        if start >= told {
            progress::at(start);
            told = start + TOLD_EVERY;
            scan.check_size(|| FilePlace::line(path, line))?;
        }
        let row = row_at(&mut text, start);
        let place = || FilePlace::line(path, line);
        if row.is_kept_apart {
            scan.odd.kept_apart.add(place);
        }
        let (end, newlines) = (row.end, row.newlines);
        let row = text.get(start..end).unwrap_or_default().trim_ascii_start();
        let length = row.iter().take_while(|b| !b.is_ascii_whitespace()).count();
        let (keyword, rest) = row.split_at(length);
        match keyword {
            b"v" => {
                let position = position(rest, place)?;
                if position.is_nan() {
                    scan.odd.positions.add(place);
                }
                scan.positions.push(position);
            }
            b"vn" => {
                let normal = normal(rest);
                if normal.is_none() {
                    scan.odd.normals.add(place);
                }
                scan.normals.push(normal.unwrap_or(UNUSABLE));
            }
            b"vt" => {
                let texcoord = texture_coordinate(rest);
                if texcoord.is_none() {
                    scan.odd.texcoords.add(place);
                }
                if scan.keeps_texcoords {
                    scan.texcoords.push(texcoord.unwrap_or([f32::NAN; 2]));
                }
                scan.texcoord_count += 1;
            }
            b"f" => scan.add_face(rest, line, place)?,
            b"usemtl" | b"mtllib" if rest.trim_ascii().is_empty() => {
                scan.odd.nameless.add(place);
                if keyword == b"usemtl" {
                    scan.switches.push((scan.faces.len(), None));
                }
            }
            b"usemtl" => {
                let index = index_of(rest, &mut names, &mut scan.used, (line, place))?;
                limits::check(index + 1, MAX_MATERIALS, "the number of materials", place)?;
                scan.switches.push((scan.faces.len(), Some(index)));
            }
            b"mtllib" => {
                let index = index_of(rest, &mut libraries, &mut scan.libraries, (line, place))?;
                limits::check(index + 1, MAX_LIBRARIES, "the number of material files", place)?;
            }
            b"l" => scan.odd.lines.add(|| FilePlace::file(path)),
            b"p" => scan.odd.points.add(|| FilePlace::file(path)),
            b"curv" | b"curv2" | b"surf" => scan.odd.curves.add(|| FilePlace::file(path)),
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
    scan.check_indices(|line| FilePlace::line(path, line))?;
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

/// The index in a list of the name that a line gives; a new name is added with its line.
fn index_of(
    name: &[u8],
    known: &mut HashMap<Vec<u8>, usize>,
    list: &mut Vec<(usize, String)>,
    (line, place): (usize, impl Fn() -> FilePlace),
) -> Result<usize, LoadError> {
    let name = name.trim_ascii();
    if let Some(&index) = known.get(name) {
        return Ok(index);
    }
    limits::check(name.len(), MAX_NAME, "the length of a name", place)?;
    known.insert(name.to_vec(), list.len());
    list.push((line, String::from_utf8_lossy(name).into_owned()));
    Ok(list.len() - 1)
}

/// Keywords that carry nothing that a scene here could show, with blanks between them.
const HARMLESS: &str = "g o s mg vp bevel c_interp d_interp lod shadow_obj trace_obj maplib usemap \
                        cstype deg bmat step parm trim hole scrv sp end con ctech stech";

fn is_harmless(keyword: &[u8]) -> bool {
    keyword.starts_with(b"#") || HARMLESS.split(' ').any(|known| known.as_bytes() == keyword)
}
