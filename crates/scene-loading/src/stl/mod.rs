//! Stereolithography files, STL (3D Systems, "StereoLithography Interface Specification", 1989), text
//! and binary.
//!
//! A file is binary when its length is what the number at byte 80 says, when it does not begin with
//! `solid`, or when zero bytes stand near its start: binary files that begin with `solid` are common.
//! Normals are those of the corners' order, colours in the attribute bytes are left out, and corners
//! in the same place become one vertex.

use std::path::Path;

use glam::DVec3;

use crate::error::{FilePlace, LoadError};
use crate::input::read::{lossy_text, scene_name};
use crate::limits::{self, MAX_ELEMENTS};
use crate::mesh::{FaceCounts, Mesh, Welder, coordinate};
use crate::nff::tokens::Words;
use crate::progress;
use crate::scene::{Material, Scene, Warning};

/// Bytes before the first triangle of a binary file: a free text, then the number of triangles.
const HEADER: usize = 84;

/// Bytes of a triangle: normal and corners as 12 f32, then two of attributes.
const TRIANGLE: usize = 50;

/// Zero bytes before this place make a file binary.
const NEAR_START: usize = 512;

/// Progress is told once for so many triangles.
const TOLD_EVERY: usize = 1 << 16;

/// Parses an STL file. `path` gives the scene its name and appears in errors, with the line or the
/// byte. Scenes have no lights, one material, and a camera that frames them.
///
/// # Errors
/// [`LoadError::Syntax`], [`LoadError::UnexpectedEnd`], [`LoadError::NotFinite`],
/// [`LoadError::OutOfRange`], [`LoadError::CountTooLarge`], [`LoadError::NoPrimitives`].
pub fn parse_stl(path: &Path, bytes: Vec<u8>) -> Result<Scene, LoadError> {
    let mut scene = Scene::new(scene_name(path));
    let material = scene.push_material(Material::default());
    let mesh = Mesh { material, first: 0, normals: None, triangulate: false };
    let mut reader =
        Reader { path, mesh, scene, welder: Welder::default(), counts: FaceCounts::default() };
    if is_binary(&bytes) {
        reader.binary(&bytes)?
    } else {
        reader.text(&lossy_text(bytes))?
    }
    progress::end();
    reader.counts.finish(reader.scene, path)
}

/// The number of triangles that a binary file states.
fn stated(bytes: &[u8]) -> Option<u32> {
    let number = bytes.get(HEADER - 4..)?.first_chunk::<4>()?;
    Some(u32::from_le_bytes(*number))
}

fn is_binary(bytes: &[u8]) -> bool {
    let length = |count| HEADER as u64 + TRIANGLE as u64 * u64::from(count);
    if stated(bytes).is_some_and(|count| length(count) == bytes.len() as u64) {
        return true;
    }
    let start = bytes.trim_ascii_start();
    let is_solid = start.get(..5).is_some_and(|word| word.eq_ignore_ascii_case(b"solid"));
    let near = bytes.get(..NEAR_START.min(bytes.len())).unwrap_or_default();
    !is_solid || near.contains(&0)
}

struct Reader<'a> {
    path: &'a Path,
    mesh: Mesh,
    scene: Scene,
    welder: Welder,
    counts: FaceCounts,
}

impl Reader<'_> {
    fn add(&mut self, corners: [DVec3; 3], place: impl Fn() -> FilePlace) -> Result<(), LoadError> {
        let size = self.scene.vertices.len().max(self.scene.primitives.len()) + 3;
        limits::check(size, MAX_ELEMENTS, "the number of vertices or triangles", &place)?;
        let corners = corners.map(|corner| self.welder.vertex(corner, &mut self.scene));
        self.mesh.add(&corners, &mut self.scene, &mut self.counts, place)
    }

    fn binary(&mut self, bytes: &[u8]) -> Result<(), LoadError> {
        let path = self.path;
        let place = |at| FilePlace::byte(path, at);
        let Some(count) = stated(bytes) else {
            let expected = "`solid`, or 80 bytes and the number of triangles".to_owned();
            return Err(LoadError::UnexpectedEnd { place: place(bytes.len()), expected });
        };
        let data = bytes.get(HEADER..).unwrap_or_default();
        let fits = data.len() / TRIANGLE;
        let count = usize::try_from(count).unwrap_or(usize::MAX);
        limits::check(count, fits, "the number of triangles", || place(HEADER - 4))?;
        let left = data.len() - count * TRIANGLE;
        if left > 0 {
            let (file, end) = (self.path.display(), HEADER + count * TRIANGLE);
            let text =
                format!("{file}: {left} bytes after the last triangle left out (byte {end})");
            self.scene.warnings.push(Warning(text));
        }
        progress::begin(count);
        for (i, record) in data.chunks_exact(TRIANGLE).take(count).enumerate() {
            if i % TOLD_EVERY == 0 {
                progress::at(i);
            }
            let at = HEADER + i * TRIANGLE;
            let within = |offset: usize| FilePlace::byte(path, at + offset);
            let numbers =
                record.as_chunks::<4>().0.iter().map(|&b| f64::from(f32::from_le_bytes(b)));
            let mut corners = [[0.0; 3]; 3];
            // the normal first, which the corners have, too
            for (k, (slot, value)) in
                corners.as_flattened_mut().iter_mut().zip(numbers.skip(3)).enumerate()
            {
                *slot = coordinate(value, "a corner", || within(12 + 4 * k))?;
            }
            self.add(corners.map(DVec3::from_array), || place(at))?;
        }
        Ok(())
    }

    /// `solid NAME`, then facets, then `endsolid NAME`; several such parts.
    fn text(&mut self, text: &str) -> Result<(), LoadError> {
        let mut words = Words::new(self.path, text);
        progress::begin(text.len());
        let mut told = 0;
        while let Some(word) = words.next() {
            let left = words.remaining();
            if text.len() - left >= told {
                progress::at(text.len() - left);
                told = text.len() - left + (1 << 20);
            }
            match word.text.to_ascii_lowercase().as_str() {
                "solid" | "endsolid" => words.skip_line(),
                "facet" => self.facet(&mut words, word.line)?,
                _ => {
                    let place = words.place(word.line);
                    return Err(LoadError::syntax(place, word.text, "facet, solid or endsolid"));
                }
            }
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
        let mut corners = [DVec3::ZERO; 3];
        for corner in &mut corners {
            let at = keyword(words, "vertex")?;
            let position = words.vector("vertex position")?;
            for value in position.to_array() {
                coordinate(value, "vertex position", || words.place(at))?;
            }
            *corner = position;
        }
        keyword(words, "endloop")?;
        keyword(words, "endfacet")?;
        let path = self.path;
        self.add(corners, || FilePlace::line(path, line))
    }
}

/// Takes a word that must be this one, in any case; the line it stands on.
fn keyword(words: &mut Words<'_>, expected: &str) -> Result<usize, LoadError> {
    let word = words.any(expected)?;
    if word.text.eq_ignore_ascii_case(expected) {
        return Ok(word.line);
    }
    Err(LoadError::syntax(words.place(word.line), word.text, expected))
}
