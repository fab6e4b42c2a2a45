//! Scenes that move: a sequence of scenes at rest, a frame each.
//!
//! Frames are made when they are asked for, so that an animation takes the memory of one.

mod files;
pub(crate) mod frames;
#[allow(clippy::indexing_slicing)]
mod generated;

use crate::aff;
use std::path::Path;

pub use crate::animation::frames::Animation;
use crate::animation::frames::RebasedAnimation;
pub use crate::animation::generated::{ANIMATED, AnimatedEntry};
use crate::error::{FilePlace, LoadError};
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
pub fn open(name: &str) -> Result<Box<dyn Animation>, LoadError> {
    if let Some(generated) = generated::open(name)? {
        return Ok(generated);
    }
    let path = path_of_name(name);
    if files::is_pattern(&path) {
        return Ok(RebasedAnimation::boxed(files::open(&path)?));
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
pub fn parse(path: &Path, bytes: Vec<u8>) -> Result<Box<dyn Animation>, LoadError> {
    let animation = match extension(path).as_str() {
        "gltf" | "glb" => gltf::animated::parse(path, &bytes),
        "aff" => aff::parse(path, bytes),
        _ => Err(LoadError::UnknownFormat {
            place: FilePlace::file(path),
            valid: ".gltf, .glb, .aff".into(),
        }),
    };
    Ok(RebasedAnimation::boxed(animation?))
}

fn unknown(name: &str) -> LoadError {
    // a misspelt name with a size is near the name
    let head = name.split(':').next().unwrap_or(name).to_lowercase();
    let names = ANIMATED.iter().map(|entry| entry.name);
    let nearest = names.clone().map(|name| (strsim::damerau_levenshtein(&head, name), name)).min();
    let suggestion = match nearest {
        Some((distance, valid)) if distance <= (valid.len() / 3).max(1) => {
            format!(" (did you mean `{valid}`?)")
        }
        _ => String::new(),
    };
    let names: Vec<&str> = names.collect();
    let valid = format!(
        "generated {} (with a size: marbles:5); sequences of files (frame%04d.obj); .gltf and .glb with an animation; .aff",
        names.join(", ")
    );
    LoadError::UnknownScene { name: name.to_owned(), suggestion, valid }
}
