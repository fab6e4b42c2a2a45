//! glTF 2.0: `.glb`, and `.gltf` with `.bin` files or data URIs, through the crate `gltf`.
//!
//! Read: triangles (lists, strips, fans) under the transforms of their nodes, skins and morph
//! targets at rest or in the first animation, instances, base colours and
//! their textures (`textures`), the first perspective camera, point and spot lights
//! (`KHR_lights_punctual`). Left out with a warning: other textures, vertex colours, points and
//! lines, orthographic cameras, directional lights, and extensions that are not read
//! (`extensions`). A file that requires one of these that may be geometry is refused.
//!
//! An animation has 25 frames per second from its first key to its last, at least [`LEAST`] and at
//! most [`MOST`]: those of a longer one are further apart. Nodes whose meshes keep their shape are
//! claimed as instances, but for those that are scaled to nothing or mirrored on the way. A triangle
//! is left out if it has no area in the mesh, in whichever frame; one that has none only in some
//! frames stays. A file without a camera is seen by the one that frames the first frame.
//!
//! The crate panics on some invalid files and believes lengths that it reads. So the container,
//! URIs, buffer views and accessors are checked here before it reads through them; images it never
//! touches; and a panic inside the crate is caught and becomes [`LoadError::Parser`] (the command
//! line keeps the panic's own message from stderr).

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use crate::animation::frames::Animation;
use crate::error::LoadError;
use crate::gltf::clip::Clip;
use crate::gltf::nodes::NodeWalker;
use crate::input::scene_name;
use crate::scene::{Camera, Scene};

pub(crate) use container::OpenedFile;

pub(crate) mod buffers;
mod clip;
mod container;
mod deform;
pub(crate) mod extensions;
mod meshes;
mod nodes;
mod textures;
pub(crate) mod tree;

/// Frames per second.
const RATE: f64 = 25.0;

/// The fewest and the most frames.
const LEAST: f64 = 2.0;
const MOST: f64 = 1500.0;

/// Parses glTF bytes, binary or JSON. `path` gives the scene its name and the folder of its
/// buffers, and appears in errors. A scene without a camera is framed.
///
/// # Errors
/// [`LoadError::GlbLength`], [`LoadError::Parser`] (malformed JSON, unsupported required
/// extensions), [`LoadError::Gltf`], [`LoadError::PastBuffer`], [`LoadError::OutsideFolder`],
/// [`LoadError::IndexOutOfRange`], [`LoadError::NotFinite`], [`LoadError::NodeReachedTwice`],
/// [`LoadError::CountTooLarge`] and [`LoadError::NoPrimitives`].
pub fn parse_gltf(path: &Path, bytes: &[u8]) -> Result<Scene, LoadError> {
    guarded(path, || {
        let opened = OpenedFile::read(path, bytes)?;
        NodeWalker::new(&opened, None).walk(None)
    })
}

/// The first animation of a file.
///
/// # Errors
/// [`LoadError::Gltf`] for a file without one or with one that breaks a rule, and those of
/// [`parse_gltf`].
pub(crate) fn parse_animation(path: &Path, bytes: &[u8]) -> Result<Animation, LoadError> {
    let (opened, clip) = guarded(path, || {
        let opened = OpenedFile::read(path, bytes)?;
        let clip = Clip::read(&opened)?;
        Ok((opened, clip))
    })?;
    let [from, to] = clip.span();
    // at most MOST
    let frames = (((to - from) * RATE).round() + 1.0).clamp(LEAST, MOST) as u32;
    let scene = move |index: u32, camera: Option<Camera>| {
        guarded(&opened.path, || {
            let share = f64::from(index) / f64::from(frames - 1);
            let pose = clip.pose(from + (to - from) * share);
            NodeWalker::new(&opened, Some(&pose)).walk(camera)
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

/// Turns a panic inside the crate `gltf` into an error.
fn guarded<T>(path: &Path, read: impl FnOnce() -> Result<T, LoadError>) -> Result<T, LoadError> {
    catch_panic(read).unwrap_or_else(|text| Err(LoadError::parser(path, text)))
}

/// Runs a reader that may panic; a panic becomes its text.
pub(crate) fn catch_panic<T>(read: impl FnOnce() -> T) -> Result<T, String> {
    catch_unwind(AssertUnwindSafe(read)).map_err(|panic| {
        let text = panic.downcast_ref::<String>().map(String::as_str);
        let text = text.or(panic.downcast_ref::<&str>().copied()).unwrap_or("unknown");
        format!("panic: {text}")
    })
}
