//! Chooses the loader of a file.

use std::path::Path;

use crate::error::{FilePlace, LoadError};
use crate::input::{decompress, read_file, text_of, unpacked_extension};
use crate::obj::ObjOptions;
use crate::scene::Scene;
use crate::{gltf, nff, obj, pbrt, ply, stl, tray_racing, triangle_soup};

/// The endings of scene files that loaders are registered for (scene descriptions, `.json`, are
/// read by [`crate::source::SceneCatalogue`]).
pub const ENDINGS: [&str; 17] = [
    ".nff", ".nff.gz", ".obj", ".obj.gz", ".obj.zst", ".gltf", ".glb", ".ply", ".ply.gz",
    ".ply.zst", ".stl", ".stl.gz", ".stl.zst", ".bin", ".ron", ".pbrt", ".pbrt.gz",
];

/// True when a loader is registered for the file's ending.
pub fn is_scene_path(path: &Path) -> bool {
    let name = path.to_string_lossy().to_ascii_lowercase();
    ENDINGS.iter().any(|ending| name.ends_with(ending))
}

/// How a scene file is read.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct ReadOptions {
    /// Split every face with more than three corners.
    pub triangulate: bool,
    /// The model that a file names as its whole content may lie outside its folder.
    pub outside: bool,
}

/// Reads a scene file as its ending says.
///
/// # Errors
/// [`LoadError::Io`], [`LoadError::TooLarge`], and those of [`parse_scene`].
pub fn load_scene(path: &Path, options: ReadOptions) -> Result<Scene, LoadError> {
    parse_scene(path, read_file(path)?, options)
}

/// Parses the bytes of a scene file as its ending says.
///
/// # Errors
/// [`LoadError::UnknownFormat`] for other endings, else the error of the loader.
pub fn parse_scene(path: &Path, bytes: Vec<u8>, options: ReadOptions) -> Result<Scene, LoadError> {
    if !is_scene_path(path) {
        let valid = ENDINGS.join(", ");
        return Err(LoadError::UnknownFormat { place: FilePlace::file(path), valid });
    }
    let bytes = decompress(path, bytes)?;
    let triangulate = options.triangulate;
    match unpacked_extension(path).as_str() {
        "nff" => nff::parse_nff(path, &text_of(path, bytes)?),
        "obj" => obj::parse_obj(path, bytes, ObjOptions { triangulate }),
        "pbrt" => pbrt::parse_pbrt(path, bytes, triangulate),
        "ron" => {
            let read = |model: &Path| load_scene(model, options);
            tray_racing::parse_tray_racing(path, bytes, options.outside, read)
        }
        "ply" => ply::parse_ply(path, &bytes, triangulate),
        "stl" => stl::parse_stl(path, bytes),
        "bin" => triangle_soup::parse_triangle_soup(path, &bytes),
        _ => gltf::parse_gltf(path, &bytes),
    }
}
