//! AFF, the format of BART's animations: NFF with transforms, keyframes, meshes and files within
//! files.
//!
//! J. Lext, U. Assarsson, T. Moeller, "A Benchmark for Animated Ray Tracing", IEEE CG&A 21(2),
//! 2001; what an entity means is taken from the descriptions in the parser that BART comes with
//! (`parse.c`, `animation.c`).
//!
//! Read are `v`, `l`, `la`, `b`, `f`, `fm`, `s`, `c`, `p`, `pp`, `m`, `tt`, `ttp`, `tpa`, `i`, `d`,
//! `x`, `xs`, `k`, `a` and `am`. Deviations:
//! - Polygons are cut into triangles.
//! - Of `fm` the diffuse colour counts, and of the specular one the largest part; ambient light
//!   (`am`) and the ambient colour have no place here.
//! - Texture coordinates are read, their images (PPM) are not: a warning counts them.
//! - Spheres and cones stand only in transforms that scale by one factor; a sphere with a negative
//!   radius is seen from both sides.
//! - The descriptions do not say whether the keys of a light (`la`) add to its place: it stays,
//!   with a warning.
//! - What is not visible is drawn together in a point, so that ids stay.

mod motion;
mod read;
mod shapes;
mod spline;
mod world;

use std::path::Path;

use crate::aff::read::read_world;
use crate::aff::world::World;
use crate::animation::frames::{Animation, check_frame};
use crate::error::{FilePlace, LoadError};
use crate::input::read::scene_name;
use crate::scene::{Camera, Scene};
use crate::view_options::light_if_dark;

struct AnimatedFiles {
    name: String,
    world: World,
    clip: (f64, f64, u32),
    /// Camera that frames the first frame, if the file has no view.
    camera: Option<Camera>,
}

/// The scene of a file and those that it includes, all below its folder.
///
/// # Errors
/// Any [`LoadError`] of reading files, [`LoadError::Syntax`], [`LoadError::UnexpectedEnd`],
/// [`LoadError::OutOfRange`], [`LoadError::NotFinite`], [`LoadError::IndexOutOfRange`],
/// [`LoadError::CountTooLarge`], [`LoadError::OutsideFolder`], [`LoadError::NoPrimitives`].
pub(crate) fn parse(path: &Path, bytes: Vec<u8>) -> Result<Box<dyn Animation>, LoadError> {
    let world = read_world(path, bytes)?;
    let clip = world.clip.ok_or_else(|| {
        let expected = "an entity `a` with start, end and number of frames";
        LoadError::unexpected_end(FilePlace::file(path), expected)
    })?;
    let mut animated = AnimatedFiles { name: scene_name(path), world, clip, camera: None };
    if !animated.world.has_view {
        let mut first = animated.scene(0)?;
        first.frame_camera();
        animated.camera = Some(first.camera);
    }
    Ok(Box::new(animated))
}

impl AnimatedFiles {
    fn scene(&self, index: u32) -> Result<Scene, LoadError> {
        let (from, to, frames) = self.clip;
        let steps = f64::from(frames.saturating_sub(1).max(1));
        let mut scene = self.world.at(from + (to - from) * f64::from(index) / steps)?;
        if let Some(camera) = self.camera {
            scene.camera = camera;
        }
        Ok(scene)
    }
}

impl Animation for AnimatedFiles {
    fn name(&self) -> &str {
        &self.name
    }

    fn frames(&self) -> u32 {
        self.clip.2
    }

    fn frame(&mut self, index: u32) -> Result<Scene, LoadError> {
        check_frame(&self.name, index, self.clip.2)?;
        let mut scene = self.scene(index)?;
        scene.name.clone_from(&self.name);
        light_if_dark(&mut scene);
        Ok(scene)
    }
}
