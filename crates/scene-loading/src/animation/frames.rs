//! Interface of moving scenes.

use std::path::Path;

use crate::error::{FilePlace, LoadError};
use crate::scene::Scene;

/// A scene that moves, frame by frame.
///
/// What is rigid in it is claimed in [`Scene::instances`], with the same object, first id and count
/// in all frames: `p` of frame 0 is at `placement_k * placement_0^-1 * p` in frame `k`, up to
/// rounding.
pub trait Animation: Send {
    fn name(&self) -> &str;

    /// Number of frames, at least one; they are numbered from 0.
    fn frames(&self) -> u32;

    /// A frame as a scene at rest. Where two frames have the same number of primitives, an id is
    /// the same primitive in both. Going forward is never slower than going back.
    ///
    /// # Errors
    /// [`LoadError::IndexOutOfRange`] beyond the last frame, else those of the loader.
    fn frame(&mut self, index: u32) -> Result<Scene, LoadError>;
}

/// Refuses a frame that there is not.
pub(crate) fn check_frame(name: &str, index: u32, frames: u32) -> Result<(), LoadError> {
    if index < frames {
        return Ok(());
    }
    Err(LoadError::IndexOutOfRange {
        place: FilePlace::file(Path::new(name)),
        what: "frame".into(),
        index: index.to_string(),
        valid: format!("there are {frames}, counted from 0"),
    })
}
