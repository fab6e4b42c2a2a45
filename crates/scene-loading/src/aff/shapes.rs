//! Primitives of AFF files, read into the space that they stand in.

use glam::DVec3;

use crate::aff::motion::AnimatedPatch;
use crate::aff::read::{Reader, name};
use crate::error::LoadError;
use crate::limits::{self, MAX_ELEMENTS};
use crate::mesh::Mesh;
use crate::nff::cone;
use crate::polygon::area_vector;
use crate::scene::index;
use crate::words::{Word, Words};

/// The most corners of a polygon.
const MAX_CORNERS: u64 = 1 << 20;

/// The fewest characters that a vector takes.
const VECTOR: usize = 6;

impl Reader {
    /// Reads the shape that a word begins.
    pub fn shape(&mut self, word: Word<'_>, words: &mut Words<'_>) -> Result<(), LoadError> {
        let scene = &self.world.rest;
        let size = scene.vertices.len().max(scene.primitives.len());
        let place = || words.place(word.line);
        limits::check(size, MAX_ELEMENTS, "the number of vertices or primitives", place)?;
        match word.text {
            "s" => {
                let center = words.vector("sphere centre")?;
                let radius = words.number("sphere radius")?.abs();
                let material = self.current_material();
                self.world.rest.push_sphere(material, center, radius);
                Ok(())
            }
            "c" => {
                let cone = cone(words, word)?;
                let material = self.current_material();
                self.world.rest.push_cone(material, cone);
                Ok(())
            }
            "m" => self.mesh(words),
            "tpa" => self.animated(words),
            "p" | "pp" => {
                let count = count(words, "the number of corners", 3, MAX_CORNERS)?;
                self.face(count, word.text == "pp", false, word, words)
            }
            _ => {
                name(words)?;
                self.textured.add(|| words.place(word.line));
                self.face(3, word.text == "ttp", true, word, words)
            }
        }
    }

    /// A polygon: corners, each with a normal or texture coordinates behind it, if the entity has
    /// them.
    fn face(
        &mut self,
        count: usize,
        with_normals: bool,
        with_texture: bool,
        word: Word<'_>,
        words: &mut Words<'_>,
    ) -> Result<(), LoadError> {
        let material = self.current_material();
        let scene = &mut self.world.rest;
        let [first, first_n] = [scene.vertices.len(), scene.normals.len()].map(index);
        for _ in 0..count {
            scene.vertices.push(words.vector("a corner")?);
            if with_normals {
                scene.normals.push(words.vector("a normal")?);
            }
            if with_texture {
                words.number("a texture coordinate")?;
                words.number("a texture coordinate")?;
            }
        }
        let normals = with_normals.then_some(first_n);
        let mesh = Mesh { material, first, normals, has_bad_normals: false, triangulate: true };
        let corners: Vec<u32> = (0..index(count)).collect();
        mesh.add(&corners, scene, &mut self.counts, || words.place(word.line))
    }

    /// A mesh: vertices, normals and texture coordinates if it has them, triangles with indices of
    /// each.
    fn mesh(&mut self, words: &mut Words<'_>) -> Result<(), LoadError> {
        let material = self.current_material();
        keyword(words, &["vertices"])?;
        let [first, first_n] =
            [self.world.rest.vertices.len(), self.world.rest.normals.len()].map(index);
        let vertices = vectors(words, "vertices")?;
        let mut normals = Vec::new();
        let mut texcoords = 0;
        let mut part = keyword(words, &["normals", "texturecoords", "triangles"])?;
        if part == "normals" {
            normals = vectors(words, "normals")?;
            part = keyword(words, &["texturecoords", "triangles"])?;
        }
        if part == "texturecoords" {
            let line = words.peek().map_or(0, |word| word.line);
            texcoords = count(words, "the number of texture coordinates", 1, MAX_ELEMENTS as u64)?;
            name(words)?;
            for _ in 0..2 * texcoords {
                words.number("a texture coordinate")?;
            }
            self.textured.add(|| words.place(line));
            keyword(words, &["triangles"])?;
        }
        let triangles = count(words, "the number of triangles", 1, MAX_ELEMENTS as u64)?;
        for _ in 0..triangles {
            let line = words.peek().map_or(0, |word| word.line);
            let v = indices(words, "vertex", vertices.len())?;
            let n = if normals.is_empty() {
                None
            } else {
                Some(indices(words, "normal", normals.len())?)
            };
            if texcoords > 0 {
                indices(words, "texture coordinate", texcoords)?;
            }
            let corners = v.map(|i| vertices.get(i as usize).copied().unwrap_or_default());
            if area_vector(&corners).is_none() {
                self.counts.without_area.add(|| words.place(line));
                continue;
            }
            let v = v.map(|i| first.saturating_add(i));
            let n = n.map(|n| n.map(|i| first_n.saturating_add(i)));
            self.world.rest.push_corners(material, v, n);
        }
        self.world.rest.vertices.extend(vertices);
        self.world.rest.normals.extend(normals);
        Ok(())
    }

    /// A triangle with corners and normals at times.
    fn animated(&mut self, words: &mut Words<'_>) -> Result<(), LoadError> {
        let times = count(words, "the number of times", 1, MAX_ELEMENTS as u64)?;
        let mut keys: Vec<(f64, [[DVec3; 2]; 3])> = Vec::new();
        for _ in 0..times {
            let line = words.peek().map_or(0, |word| word.line);
            let time = words.number("a time")?;
            if let Some((last, _)) = keys.last().filter(|(last, _)| *last >= time) {
                let (place, what) = (words.place(line), "the time of a triangle");
                let expected = format!("more than {last}, that of the one before");
                return Err(LoadError::out_of_range(place, what, time, expected));
            }
            let mut corners = [[DVec3::ZERO; 2]; 3];
            for corner in &mut corners {
                *corner = [words.vector("a corner")?, words.vector("a normal")?];
            }
            keys.push((time, corners));
        }
        let Some((_, corners)) = keys.first().copied() else { return Ok(()) };
        let material = self.current_material();
        let scene = &mut self.world.rest;
        let first = [scene.vertices.len(), scene.normals.len()];
        let [vertices, normals] = [0, 1].map(|k| corners.map(|c| if k == 0 { c[0] } else { c[1] }));
        scene.push_patch(material, vertices, normals);
        self.world.patches.push(AnimatedPatch { first, keys });
        Ok(())
    }
}

/// One of these words.
fn keyword<'a>(words: &mut Words<'a>, valid: &[&str]) -> Result<&'a str, LoadError> {
    let expected = valid.join(" or ");
    let word = words.any(&expected)?;
    if valid.contains(&word.text) {
        Ok(word.text)
    } else {
        Err(LoadError::syntax(words.place(word.line), word.text, expected))
    }
}

/// A number of things that the rest of the file can hold: each takes at least two characters.
fn count(words: &mut Words<'_>, what: &str, min: u64, max: u64) -> Result<usize, LoadError> {
    let line = words.peek().map_or(0, |word| word.line);
    let count = words.integer(what, min, max)? as usize;
    limits::check(count, words.remaining() / 2 + 1, what, || words.place(line))?;
    Ok(count)
}

fn vectors(words: &mut Words<'_>, what: &str) -> Result<Vec<DVec3>, LoadError> {
    let count = count(words, what, 1, MAX_ELEMENTS as u64)?;
    let mut vectors = Vec::with_capacity(count.min(words.remaining() / VECTOR + 1));
    for _ in 0..count {
        vectors.push(words.vector(what)?);
    }
    Ok(vectors)
}

/// Three indices, each below `count`.
fn indices(words: &mut Words<'_>, what: &str, count: usize) -> Result<[u32; 3], LoadError> {
    let mut indices = [0; 3];
    for index in &mut indices {
        let line = words.peek().map_or(0, |word| word.line);
        let value = words.integer(what, 0, u64::MAX)?;
        if value >= count as u64 {
            let valid = format!("there are {count}, counted from 0");
            return Err(LoadError::bad_index(words.place(line), what, value, valid));
        }
        // below a count within memory and the limits
        *index = value as u32;
    }
    Ok(indices)
}
