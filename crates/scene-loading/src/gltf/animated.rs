//! glTF files as scenes that move: the first animation, sampled at uniform times.
//!
//! 25 frames per second from its first key to its last, at least [`LEAST`] and at most [`MOST`]:
//! those of a longer one are further apart. Nodes whose meshes keep their shape are claimed as
//! instances, but for those that are scaled to nothing or mirrored on the way. A triangle is left
//! out if it has no area in the mesh, in whichever frame; one that has none only in some frames
//! stays. A file without a camera is seen by the one that frames the first frame.

use std::path::Path;

use crate::animation::frames::{Animation, check_frame};
use crate::error::LoadError;
use crate::gltf::clip::Clip;
use crate::gltf::{OpenedFile, guarded};
use crate::input::read::scene_name;
use crate::scene::{Camera, Scene};
use crate::view_options::light_if_dark;

/// Frames per second.
const RATE: f64 = 25.0;

/// The fewest and the most frames.
const LEAST: f64 = 2.0;
const MOST: f64 = 1500.0;

struct AnimatedFile {
    name: String,
    opened: OpenedFile,
    clip: Clip,
    frames: u32,
    /// Camera of the first frame, once that exists.
    camera: Option<Camera>,
}

/// The first animation of a file.
///
/// # Errors
/// [`LoadError::Gltf`] for a file without one or with one that breaks a rule, and those of
/// [`crate::gltf::parse_gltf`].
pub(crate) fn parse(path: &Path, bytes: &[u8]) -> Result<Box<dyn Animation>, LoadError> {
    guarded(path, || {
        let opened = OpenedFile::read(path, bytes)?;
        let clip = Clip::read(path, &opened.document, &opened.buffers)?;
        let [from, to] = clip.span();
        let frames = ((to - from) * RATE).round() + 1.0;
        // at most MOST
        let frames = frames.clamp(LEAST, MOST) as u32;
        let animated = AnimatedFile { name: scene_name(path), opened, clip, frames, camera: None };
        Ok(Box::new(animated) as Box<dyn Animation>)
    })
}

impl AnimatedFile {
    fn scene(&self, index: u32) -> Result<Scene, LoadError> {
        guarded(&self.opened.path, || {
            let [from, to] = self.clip.span();
            let share = f64::from(index) / f64::from(self.frames - 1);
            let pose = self.clip.pose(from + (to - from) * share);
            let mut walker = self.opened.walker().posed(&pose);
            walker.walk(&self.opened.scene()?)?;
            walker.finish(self.camera)
        })
    }
}

impl Animation for AnimatedFile {
    fn name(&self) -> &str {
        &self.name
    }

    fn frames(&self) -> u32 {
        self.frames
    }

    fn frame(&mut self, index: u32) -> Result<Scene, LoadError> {
        check_frame(&self.name, index, self.frames)?;
        if self.camera.is_none() && index > 0 {
            self.camera = Some(self.scene(0)?.camera);
        }
        let mut scene = self.scene(index)?;
        self.camera.get_or_insert(scene.camera);
        light_if_dark(&mut scene);
        Ok(scene)
    }
}
