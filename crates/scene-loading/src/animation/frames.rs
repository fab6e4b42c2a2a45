//! Scenes that move, frame by frame.

use std::path::Path;

use crate::error::{FilePlace, LoadError};
use crate::scene::Scene;
use crate::scene::origin::origin_for;
use crate::view_options::light_if_dark;

/// A scene that moves, frame by frame.
///
/// What is rigid in it is claimed in [`Scene::instances`], with the same object, first id and count
/// in all frames: `p` of frame 0 is at `placement_k * placement_0^-1 * p` in frame `k`, up to
/// rounding.
pub struct Animation {
    name: String,
    frames: u32,
    make: Box<dyn FnMut(u32) -> Result<Scene, LoadError> + Send>,
}

impl Animation {
    /// `make` makes the frames below `frames`, in any order.
    pub(crate) fn new(
        name: String,
        frames: u32,
        make: impl FnMut(u32) -> Result<Scene, LoadError> + Send + 'static,
    ) -> Self {
        Self { name, frames, make: Box::new(make) }
    }

    pub fn name(&self) -> &str {
        &self.name
    }

    /// Number of frames, at least one; they are numbered from 0.
    pub fn frames(&self) -> u32 {
        self.frames
    }

    /// A frame as a scene at rest; without lights it gets one at the eye. Where two frames have the
    /// same number of primitives, an id is the same primitive in both. Going forward is never
    /// slower than going back.
    ///
    /// # Errors
    /// [`LoadError::IndexOutOfRange`] beyond the last frame, else those of the loader.
    pub fn frame(&mut self, index: u32) -> Result<Scene, LoadError> {
        if index >= self.frames {
            let place = FilePlace::file(Path::new(&self.name));
            let valid = format!("there are {}, counted from 0", self.frames);
            return Err(LoadError::bad_index(place, "frame", index, valid));
        }
        let mut scene = (self.make)(index)?;
        scene.name.clone_from(&self.name);
        light_if_dark(&mut scene);
        Ok(scene)
    }

    /// With all frames near the origin, moved there as the first one is.
    pub(super) fn rebased(self) -> Self {
        self.with_first(|first| origin_for(&first.bounds()), Scene::bring_to)
    }

    /// With the camera of the first frame in all frames.
    pub(crate) fn seen_as_first(self) -> Self {
        self.with_first(|first| first.camera, |scene, camera| scene.camera = camera)
    }

    /// With something that `of` finds in the first frame applied to all frames.
    fn with_first<T: Copy + Send + 'static>(
        self,
        of: fn(&Scene) -> T,
        apply: fn(&mut Scene, T),
    ) -> Self {
        let (mut make, mut known) = (self.make, None);
        Self::new(self.name, self.frames, move |index| {
            let mut scene = make(index)?;
            let first = match known {
                Some(first) => first,
                None if index == 0 => of(&scene),
                None => of(&make(0)?),
            };
            apply(&mut scene, *known.insert(first));
            Ok(scene)
        })
    }
}
