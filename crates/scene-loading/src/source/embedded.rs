//! The scene files, sets and small assets of the folder `scenes/`, compiled in so that the
//! program works from any folder.

use crate::error::LoadError;
use crate::procedural;
use crate::scene::Scene;
use crate::tessellate::{TessellationOptions, tessellate as into_triangles};

macro_rules! embed {
    ($($path:literal),* $(,)?) => {
        &[$((concat!("scenes/", $path), include_str!(concat!("../../scenes/", $path)))),*]
    };
}

/// Scene files: path in the repository and text.
pub(crate) static SCENES: &[(&str, &str)] = embed![
    "balls-tess.json",
    "effects/effect-all.json",
    "effects/effect-focus.json",
    "effects/effect-gloss.json",
    "effects/effect-hard-shadows.json",
    "effects/effect-mirror.json",
    "effects/effect-motion.json",
    "effects/effect-plain.json",
    "effects/effect-refraction.json",
    "effects/effect-smooth-normals.json",
    "effects/effect-soft-shadows.json",
    "effects/effect-supersampling.json",
    "effects/effect-textures.json",
    "gears-tess.json",
    "gears8-tess.json",
    "kitchen.json",
    "pavilion.json",
    "sponza.json",
    "tree-tess.json",
];

/// Set files: path in the repository and text.
pub(crate) static SETS: &[(&str, &str)] = embed![
    "sets/effects.json",
    "sets/real.json",
    "sets/small.json",
    "sets/spd.json",
    "sets/speed.json"
];

/// Files that scene files refer to: path in the repository and bytes.
pub(crate) static ASSETS: &[(&str, &[u8])] = &[
    ("scenes/pavilion.glb", include_bytes!("../../scenes/pavilion.glb")),
    (
        "scenes/effects/effect-textures.gltf",
        include_bytes!("../../scenes/effects/effect-textures.gltf"),
    ),
];

/// The names of the generators.
pub(crate) fn families() -> Vec<&'static str> {
    procedural::generators().map(|entry| entry.name).collect()
}

/// Generates `balls` or `balls:5`.
pub(crate) fn generate(spec: &str) -> Result<Scene, LoadError> {
    procedural::generate(spec).map_err(|error| LoadError::procedural(spec, error))
}

/// Turns spheres, cones and polygons into triangles.
pub(crate) fn tessellate(scene: &Scene, resolution: u32) -> Result<Scene, LoadError> {
    into_triangles(scene, &TessellationOptions { resolution })
        .map_err(|error| LoadError::procedural(&scene.name, error))
}
