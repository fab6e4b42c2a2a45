//! glTF files as scenes that move: the first animation, sampled at uniform times.
//!
//! 25 frames per second from its first key to its last, at least [`LEAST`] and at most [`MOST`]:
//! those of a longer one are further apart. Nodes whose meshes keep their shape are claimed as
//! instances, but for those that are scaled to nothing or mirrored on the way. A triangle is left
//! out if it has no area in the mesh, in whichever frame; one that has none only in some frames
//! stays. A file without a camera is seen by the one that frames the first frame.

use std::path::Path;

use crate::animation::frames::Animation;
use crate::error::LoadError;
use crate::gltf::clip::Clip;
use crate::gltf::{OpenedFile, guarded};
use crate::input::read::scene_name;
use crate::scene::Camera;

/// Frames per second.
const RATE: f64 = 25.0;

/// The fewest and the most frames.
const LEAST: f64 = 2.0;
const MOST: f64 = 1500.0;

/// The first animation of a file.
///
/// # Errors
/// [`LoadError::Gltf`] for a file without one or with one that breaks a rule, and those of
/// [`crate::gltf::parse_gltf`].
pub(crate) fn parse(path: &Path, bytes: &[u8]) -> Result<Animation, LoadError> {
    let (opened, clip) = guarded(path, || {
        let opened = OpenedFile::read(path, bytes)?;
        let clip = Clip::read(path, &opened.document, &opened.buffers)?;
        Ok((opened, clip))
    })?;
    let [from, to] = clip.span();
    // at most MOST
    let frames = (((to - from) * RATE).round() + 1.0).clamp(LEAST, MOST) as u32;
    let scene = move |index: u32, camera: Option<Camera>| {
        guarded(&opened.path, || {
            let share = f64::from(index) / f64::from(frames - 1);
            let pose = clip.pose(from + (to - from) * share);
            let mut walker = opened.walker().posed(&pose);
            walker.walk(&opened.scene()?)?;
            walker.finish(camera)
        })
    };
    // that of the first frame, once it is known
    let mut camera = None;
    Ok(Animation::new(scene_name(path), frames, move |index| {
        if camera.is_none() && index > 0 {
            camera = Some(scene(0, None)?.camera);
        }
        let scene = scene(index, camera)?;
        camera.get_or_insert(scene.camera);
        Ok(scene)
    }))
}
