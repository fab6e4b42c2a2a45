//! Interface of moving scenes.

use std::path::Path;

use crate::error::{FilePlace, LoadError};
use crate::scene::Scene;
use crate::scene::origin::origin_for;
use glam::DVec3;

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
    let (place, valid) =
        (FilePlace::file(Path::new(name)), format!("there are {frames}, counted from 0"));
    Err(LoadError::bad_index(place, "frame", index, valid))
}

pub(super) struct RebasedAnimation {
    frames: Box<dyn Animation>,
    /// Known once the first frame was made.
    origin: Option<DVec3>,
}

impl RebasedAnimation {
    pub fn boxed(frames: Box<dyn Animation>) -> Box<dyn Animation> {
        Box::new(Self { frames, origin: None })
    }
}

impl Animation for RebasedAnimation {
    fn name(&self) -> &str {
        self.frames.name()
    }

    fn frames(&self) -> u32 {
        self.frames.frames()
    }

    fn frame(&mut self, index: u32) -> Result<Scene, LoadError> {
        let mut scene = self.frames.frame(index)?;
        let origin = match self.origin {
            Some(origin) => origin,
            None if index == 0 => origin_for(&scene.bounds()),
            None => origin_for(&self.frames.frame(0)?.bounds()),
        };
        self.origin = Some(origin);
        scene.bring_to(origin);
        Ok(scene)
    }
}
