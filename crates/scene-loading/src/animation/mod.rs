//! Scenes that move: a sequence of scenes at rest, a frame each.
//!
//! Frames are made when they are asked for, so that an animation takes the memory of one.

mod files;
pub(crate) mod frames;
#[allow(clippy::indexing_slicing)]
mod generated;

use std::path::Path;

use crate::aff;
pub use crate::animation::frames::Animation;
pub use crate::animation::generated::{ANIMATED, AnimatedEntry};
use crate::error::{FilePlace, LoadError, suggestion};
use crate::gltf;
use crate::input::read::{extension, read_file};
use crate::source::names::path_of_name;

/// Opens an animation by its name: a generated one, at its default size (`marbles`) or another
/// (`marbles:5`), or the path of a sequence of files (`frame%04d.obj`) of a
/// glTF file with an animation, or of an AFF file.
///
/// # Errors
/// [`LoadError::UnknownScene`] with all valid names and the nearest one, [`LoadError::Procedural`]
/// for a size that there is not, [`LoadError::NoFrames`], [`LoadError::MissingFrame`],
/// [`LoadError::UnknownFormat`], [`LoadError::Io`], and those of [`parse`].
pub fn open(name: &str) -> Result<Animation, LoadError> {
    if let Some(generated) = generated::open(name)? {
        return Ok(generated);
    }
    let path = path_of_name(name);
    if files::is_pattern(&path) {
        return Ok(files::open(&path)?.rebased());
    }
    if is_moving(&path) { parse(&path, read_file(&path)?) } else { Err(unknown(name)) }
}

/// True for formats that hold a whole animation in a file.
fn is_moving(path: &Path) -> bool {
    ["gltf", "glb", "aff"].contains(&extension(path).as_str())
}

/// The animation in the bytes of a glTF or AFF file, as its ending says. `path` gives it its name
/// and the folder of the files that it names, and appears in errors. Far from the origin, all
/// frames are moved near it as the first one is: [`Scene::origin`](crate::Scene::origin).
///
/// # Errors
/// [`LoadError::UnknownFormat`] for other endings, else those of the loader.
pub fn parse(path: &Path, bytes: Vec<u8>) -> Result<Animation, LoadError> {
    let animation = match extension(path).as_str() {
        "gltf" | "glb" => gltf::parse_animation(path, &bytes),
        "aff" => aff::parse(path, bytes),
        _ => Err(LoadError::UnknownFormat {
            place: FilePlace::file(path),
            valid: ".gltf, .glb, .aff".into(),
        }),
    };
    Ok(animation?.rebased())
}

fn unknown(name: &str) -> LoadError {
    let names: Vec<&str> = ANIMATED.iter().map(|entry| entry.name).collect();
    let valid = format!(
        "generated {} (with a size: marbles:5); sequences of files (frame%04d.obj); .gltf and .glb with an animation; .aff",
        names.join(", ")
    );
    LoadError::UnknownScene { name: name.to_owned(), suggestion: suggestion(name, &names), valid }
}
