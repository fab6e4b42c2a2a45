//! Faces over a list of vertices, as PLY, STL and PBRT have them: what becomes of each, and what is
//! counted. They are taken as OBJ's are: a triangle stays one; a larger flat face is a polygon
//! unless it has normals or triangles are asked for; faces without area are left out.

use std::collections::HashMap;
use std::path::Path;

use glam::DVec3;

use crate::error::{FilePlace, LoadError, Within};
use crate::limits::{self, MAX_ELEMENTS};
use crate::polygon::ear_clipping::{triangulate, triangulate_bent};
use crate::polygon::{area_vector, is_flat};
use crate::scene::{Primitive, Scene, Shape, Warning};

/// Coordinates above this cannot be worked with: their cubes must stay finite.
pub(crate) const MAX_COORDINATE: f64 = 1e100;

/// Faces that were not taken as they are.
#[derive(Debug, Default)]
pub(crate) struct FaceCounts {
    without_area: Tally,
    bent: Tally,
}

/// How many, and where the first is.
#[derive(Debug, Default)]
pub(crate) struct Tally {
    count: usize,
    first: Option<FilePlace>,
}

impl Tally {
    pub fn add(&mut self, place: impl FnOnce() -> FilePlace) {
        self.count += 1;
        self.first.get_or_insert_with(place);
    }

    /// A warning where there is anything: how many of what, and where the first is.
    pub fn warn(&self, what: &str, scene: &mut Scene) {
        let Some(FilePlace { file, within }) = &self.first else { return };
        let first = match within {
            Within::Whole => String::new(),
            Within::Line(line) => format!(" (first: line {line})"),
            Within::Byte(byte) => format!(" (first: byte {byte})"),
        };
        let text = format!("{}: {} {what}{first}", file.display(), self.count);
        scene.warnings.push(Warning(text));
    }
}

impl FaceCounts {
    /// Counts a face without area that its reader has left out.
    pub fn without_area(&mut self, place: impl FnOnce() -> FilePlace) {
        self.without_area.add(place);
    }

    /// One warning for each kind.
    pub fn warn(&self, scene: &mut Scene) {
        self.without_area.warn("faces without area left out", scene);
        self.bent.warn("faces that are not flat split", scene);
    }

    /// The scene of a file of triangles alone: warned of, seen by a camera that frames it.
    ///
    /// # Errors
    /// [`LoadError::NoPrimitives`] where no triangle is left.
    pub fn finish(&self, mut scene: Scene, path: &Path) -> Result<Scene, LoadError> {
        self.warn(&mut scene);
        if scene.primitives.is_empty() {
            let expected = "triangle with an area";
            return Err(LoadError::NoPrimitives { place: FilePlace::file(path), expected });
        }
        scene.frame_camera();
        Ok(scene)
    }
}

/// Where the vertices of a mesh are in a scene, and what its faces have in common.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Mesh {
    /// Of all faces.
    pub material: u32,
    /// The first vertex in `Scene::vertices`.
    pub first: u32,
    /// The first normal in `Scene::normals`, where each vertex has one.
    pub normals: Option<u32>,
    /// Larger faces are split into triangles.
    pub triangulate: bool,
}

impl Mesh {
    /// Adds a face by the places of its corners in the mesh, which must be valid.
    pub fn add(
        &self,
        corners: &[u32],
        scene: &mut Scene,
        counts: &mut FaceCounts,
        place: impl Fn() -> FilePlace,
    ) -> Result<(), LoadError> {
        let point = |&i: &u32| scene.vertices.get(self.first as usize + i as usize).copied();
        if let [a, b, c] = corners {
            let points = [point(a), point(b), point(c)].map(Option::unwrap_or_default);
            if area_vector(&points).is_none() {
                counts.without_area.add(place);
            } else {
                self.push([*a, *b, *c], scene);
            }
            return Ok(());
        }
        let points: Vec<DVec3> = corners.iter().filter_map(point).collect();
        let Some(area) = area_vector(&points) else {
            counts.without_area.add(place);
            return Ok(());
        };
        // a face makes at most as many vertices and primitives as it has corners
        let size = scene.vertices.len().max(scene.primitives.len()) + corners.len();
        limits::check(size, MAX_ELEMENTS, "the number of vertices or triangles", &place)?;
        let flat = is_flat(&points, area);
        if !flat {
            counts.bent.add(&place);
        }
        if flat && self.normals.is_none() && !self.triangulate {
            scene.push_polygon(self.material, &points);
            return Ok(());
        }
        let pieces = if flat { triangulate(&points) } else { triangulate_bent(&points, area) };
        let pieces = pieces.map_err(|source| LoadError::Entangled { place: place(), source })?;
        for piece in pieces {
            let pick = piece.map(|i| corners.get(i as usize).copied().unwrap_or_default());
            let at = piece.map(|i| points.get(i as usize).copied().unwrap_or_default());
            if area_vector(&at).is_some() {
                self.push(pick, scene);
            }
        }
        Ok(())
    }

    fn push(&self, corners: [u32; 3], scene: &mut Scene) {
        let v = corners.map(|i| self.first.saturating_add(i));
        let shape = match self.normals {
            Some(first) => Shape::Patch { v, n: corners.map(|i| first.saturating_add(i)) },
            None => Shape::Triangle { v },
        };
        scene.primitives.push(Primitive { shape, material: self.material });
    }
}

/// Vertices of formats that list triangles without indices: those in the same place become one.
#[derive(Debug, Default)]
pub(crate) struct Welder(HashMap<[u64; 3], u32>);

impl Welder {
    /// The place of a vertex in the scene; it is added where it is new.
    pub fn vertex(&mut self, position: DVec3, scene: &mut Scene) -> u32 {
        // 0 and -0 are the same place
        let key = position.to_array().map(|x| (x + 0.0).to_bits());
        *self.0.entry(key).or_insert_with(|| {
            scene.vertices.push(position);
            u32::try_from(scene.vertices.len() - 1).unwrap_or(u32::MAX)
        })
    }
}

/// A coordinate that can be worked with.
pub(crate) fn coordinate(
    value: f64,
    what: &str,
    place: impl Fn() -> FilePlace,
) -> Result<f64, LoadError> {
    if value.abs() <= MAX_COORDINATE {
        return Ok(value);
    }
    let (what, found) = (what.to_owned(), value.to_string());
    if !value.is_finite() {
        return Err(LoadError::NotFinite { place: place(), what, found });
    }
    let expected = format!("at most {MAX_COORDINATE:e} in size");
    Err(LoadError::OutOfRange { place: place(), what, found, expected })
}
