//! The `.ron` scene files of tray_racing (github.com/DGriffin91/tray_racing, `assets/scenes`): a
//! model in a file of its own, a camera, and the direction of sunlight.
//!
//! ```ron
//! (
//!     model_path: "assets/obj/kitchen.obj",
//!     camera: (eye: (3.0, 1.5, 1.4), look_at: (-3.9, 1.5, -1.7), fov: 90.0, exposure: -1.0),
//!     sun_direction: (-0.27, -0.24, 1.0),
//! )
//! ```
//!
//! The field of view is the vertical one, of a square image both; up is y; the exposure is left
//! out. The sun is a point light [`SUN_DISTANCE`] times the scene's radius away: its rays differ in
//! direction by 0.6 degrees at most. The model is looked for in the folder of the scene file and,
//! where scenes may read outside of it (`--allow-outside`), as tray_racing does: two folders above
//! that one.

use std::path::{Path, PathBuf};

use glam::DVec3;
use serde::Deserialize;

use crate::error::{FilePlace, LoadError, shortened};
use crate::input::{confined, extension, text_of};
use crate::limits::MAX_JSON;
use crate::mesh::coordinate;
use crate::scene::{Bounds, Camera, Light, Scene};

/// How far away the sun is, in radii of the scene.
pub const SUN_DISTANCE: f64 = 100.0;

/// How deep parentheses may nest.
const MAX_DEPTH: usize = 16;

#[derive(Debug, Deserialize)]
#[serde(rename = "Scene")]
struct SceneEntry {
    model_path: String,
    camera: CameraEntry,
    sun_direction: [f64; 3],
}

#[derive(Debug, Deserialize)]
#[serde(rename = "Camera")]
struct CameraEntry {
    eye: [f64; 3],
    look_at: [f64; 3],
    fov: f64,
}

/// Parses a scene file; `read_model` reads the file that it names. That may lie outside the folder
/// where `outside` says so.
///
/// # Errors
/// [`LoadError::Parser`] with the line, [`LoadError::OutOfRange`], [`LoadError::OutsideSource`] for
/// a model that is not in the folder, and those of the model's reader.
pub fn parse_tray_racing(
    path: &Path,
    bytes: Vec<u8>,
    outside: bool,
    read_model: impl FnOnce(&Path) -> Result<Scene, LoadError>,
) -> Result<Scene, LoadError> {
    if bytes.len() as u64 > MAX_JSON {
        return Err(LoadError::too_large(path, MAX_JSON));
    }
    let reader = ron::Options::default().with_recursion_limit(MAX_DEPTH);
    let entry: SceneEntry = reader.from_str(&text_of(path, bytes)?).map_err(|error| {
        let place = FilePlace::line(path, error.span.start.line);
        LoadError::Parser { place, parser: "ron", message: error.code.to_string() }
    })?;
    let place = || FilePlace::file(path);
    let CameraEntry { eye, look_at, fov } = entry.camera;
    let named = [("eye", eye), ("look_at", look_at), ("sun_direction", entry.sun_direction)];
    for (name, values) in named {
        values.into_iter().try_for_each(|value| coordinate(value, name, place).map(drop))?;
    }
    let camera = Camera {
        from: DVec3::from_array(eye),
        at: DVec3::from_array(look_at),
        up: DVec3::Y,
        angle: fov,
        ..Camera::default()
    };
    camera.check(place)?;
    let model = model_of(path, &entry.model_path, outside)?;
    if matches!(extension(&model).as_str(), "ron" | "json") {
        let expected = "a model_path of a mesh: .obj, .glb, .ply, ...";
        return Err(LoadError::syntax(place(), &entry.model_path, expected));
    }
    let mut scene = read_model(&model)?;
    scene.camera = camera;
    let sun = DVec3::from_array(entry.sun_direction).normalize_or_zero();
    let bounds = scene.bounds();
    if sun != DVec3::ZERO && !bounds.is_empty() {
        scene.lights = vec![Light::point(sun_position(&bounds, sun), None)];
    }
    Ok(scene)
}

/// Where a point light stands for the sun, whose light goes along a direction.
pub(crate) fn sun_position(bounds: &Bounds, along: DVec3) -> DVec3 {
    let (center, radius) = ((bounds.min + bounds.max) * 0.5, bounds.size().length() * 0.5);
    center - along * (radius * SUN_DISTANCE)
}

/// The file that a scene file names as its model.
fn model_of(path: &Path, name: &str, outside: bool) -> Result<PathBuf, LoadError> {
    let folder = path.parent().unwrap_or(Path::new(""));
    if let Some(inside) = confined(folder, name).filter(|file| file.is_file()) {
        return Ok(inside);
    }
    if !outside {
        let (place, path) = (FilePlace::file(path), shortened(name));
        return Err(LoadError::OutsideSource { place, path });
    }
    Ok(folder.join("../..").join(name))
}
