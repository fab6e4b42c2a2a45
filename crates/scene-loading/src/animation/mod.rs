//! Scenes that move: a sequence of scenes at rest, a frame each.
//!
//! Frames are made when they are asked for, so that an animation takes the memory of one.

mod files;
#[allow(clippy::indexing_slicing)]
mod generated;

use std::path::Path;

use crate::aff;
pub use crate::animation::generated::{ANIMATED, AnimatedEntry};
use crate::error::{LoadError, Place};
use crate::gltf;
use crate::input::read::extension;
use crate::scene::Scene;
use crate::source::names::path_of_name;

/// A scene that moves, frame by frame.
///
/// What is rigid in it is claimed in [`Scene::instances`], with the same object, first id and count in all
/// frames: `p` of frame 0 is at `placement_k * placement_0^-1 * p` in frame `k`, up to rounding.
pub trait Animation: Send {
    /// Name in tables.
    fn name(&self) -> &str;

    /// Number of frames, at least one; they are numbered from 0.
    fn frames(&self) -> u32;

    /// A frame as a scene at rest. Where two frames have the same number of primitives, an id is the same
    /// primitive in both. Going forward is never slower than going back.
    ///
    /// # Errors
    /// [`LoadError::IndexOutOfRange`] beyond the last frame, else those of the loader.
    fn frame(&mut self, index: u32) -> Result<Scene, LoadError>;
}

/// Opens an animation by its name: a generated one, at its default size (`marbles`) or another
/// (`marbles:5`), or the path of a sequence of files (`frame%04d.obj`) of a
/// glTF file with an animation, or of an AFF file.
///
/// # Errors
/// [`LoadError::UnknownScene`] with all valid names and the nearest one, [`LoadError::Procedural`] for a
/// size that there is not, [`LoadError::NoFrames`], [`LoadError::MissingFrame`],
/// [`LoadError::UnknownFormat`], [`LoadError::Io`], and of glTF files those of [`gltf::parse_gltf`].
pub fn open(name: &str) -> Result<Box<dyn Animation>, LoadError> {
    if let Some(generated) = generated::open(name)? {
        return Ok(generated);
    }
    let path = path_of_name(name);
    if files::is_pattern(&path) {
        return files::open(&path);
    }
    if ["gltf", "glb"].contains(&extension(&path).as_str()) {
        return gltf::animated::open(&path);
    }
    if extension(&path) == "aff" {
        return aff::open(&path);
    }
    Err(unknown(name))
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

/// Refuses a frame that there is not.
pub(crate) fn check_frame(name: &str, index: u32, frames: u32) -> Result<(), LoadError> {
    if index < frames {
        return Ok(());
    }
    Err(LoadError::IndexOutOfRange {
        place: Place::file(Path::new(name)),
        what: "frame".into(),
        index: index.to_string(),
        valid: format!("there are {frames}, counted from 0"),
    })
}
