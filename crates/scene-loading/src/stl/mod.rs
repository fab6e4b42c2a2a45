//! Stereolithography files, STL (3D Systems, "StereoLithography Interface Specification", 1989),
//! text and binary.
//!
//! A file is binary when its length is what the number at byte 80 says, when it begins neither with
//! `solid` nor has a `facet` near its start, or when zero bytes stand there: binary files that
//! begin with `solid` are common. Normals are those of the corners' order, colours in the attribute
//! bytes are left out, and corners in the same place become one vertex. Triangles with a corner
//! that is NaN are left out.

mod binary;
mod reader;
mod text;

use std::path::Path;

use crate::error::LoadError;
use crate::input::read::scene_name;
use crate::input::text::text_of;
use crate::mesh::{FaceCounts, Mesh, Welder};
use crate::progress;
use crate::scene::{Material, Scene};
use crate::stl::reader::Reader;

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
