//! Stereolithography files, STL (3D Systems, "StereoLithography Interface Specification", 1989), text
//! and binary.
//!
//! A file is binary when its length is what the number at byte 80 says, when it begins neither with
//! `solid` nor has a `facet` near its start, or when zero bytes stand there: binary files that begin
//! with `solid` are common. Normals are those of the corners' order, colours in the attribute bytes
//! are left out, and corners in the same place become one vertex. Triangles with a corner that is
//! NaN are left out.

mod binary;
mod text;

use std::path::Path;

use glam::DVec3;

use crate::error::{FilePlace, LoadError};
use crate::input::read::scene_name;
use crate::input::text::text_of;
use crate::limits::{self, MAX_ELEMENTS};
use crate::mesh::{FaceCounts, Mesh, Welder, usable};
use crate::progress;
use crate::scene::{Material, Scene, Warning};

/// Parses an STL file. `path` gives the scene its name and appears in errors, with the line or the
/// byte. Scenes have no lights, one material, and a camera that frames them.
///
/// # Errors
/// [`LoadError::Syntax`], [`LoadError::UnexpectedEnd`], [`LoadError::CountTooLarge`],
/// [`LoadError::NoPrimitives`].
pub fn parse_stl(path: &Path, bytes: Vec<u8>) -> Result<Scene, LoadError> {
    let mut scene = Scene::new(scene_name(path));
    let mesh = Mesh::of_triangles(scene.push_material(Material::default()));
    let mut reader =
        Reader { path, mesh, scene, welder: Welder::default(), counts: FaceCounts::default() };
    if binary::is_binary(path, &bytes)? {
        reader.binary(&bytes)?
    } else {
        reader.text(&text_of(path, bytes)?)?
    }
    progress::end();
    reader.counts.finish(reader.scene, path)
}

struct Reader<'a> {
    path: &'a Path,
    mesh: Mesh,
    scene: Scene,
    welder: Welder,
    counts: FaceCounts,
}

impl Reader<'_> {
    fn add(
        &mut self,
        corners: [[f64; 3]; 3],
        place: impl Fn() -> FilePlace,
    ) -> Result<(), LoadError> {
        let size = self.scene.vertices.len().max(self.scene.primitives.len()) + 3;
        limits::check(size, MAX_ELEMENTS, "the number of vertices or triangles", &place)?;
        let corners = corners.map(|corner| DVec3::from_array(corner.map(usable)));
        if corners.iter().any(|corner| corner.is_nan()) {
            self.counts.unusable(place);
            return Ok(());
        }
        let corners = corners.map(|corner| self.welder.vertex(corner, &mut self.scene));
        self.mesh.add(&corners, &mut self.scene, &mut self.counts, place)
    }

    fn warn(&mut self, text: String) {
        self.scene.warnings.push(Warning(format!("{}: {text}", self.path.display())));
    }
}
