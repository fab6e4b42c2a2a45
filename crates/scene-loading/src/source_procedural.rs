//! The one place where the catalogue calls the SPD generators and the tessellator.
//!
//! STUB: the modules `procedural` and `tessellate` are on the branch `spd`. Once both branches
//! are merged, the bodies become the calls in the comments and this note goes.

use crate::error::LoadError;
use crate::scene::Scene;

/// The names of the generators.
pub(crate) fn families() -> Vec<&'static str> {
    // procedural::SPD.iter().map(|entry| entry.name).collect()
    vec!["balls", "gears", "lattice", "mount", "rings", "teapot", "tetra", "tree"]
}

/// Generates `balls` or `balls:5`.
pub(crate) fn generate(spec: &str) -> Result<Scene, LoadError> {
    // procedural::generate(spec).map_err(|e| error(spec, e.to_string()))
    Err(error(spec, "the generators are not part of this build".to_string()))
}

/// Turns spheres, cones and polygons into triangles.
pub(crate) fn tessellate(scene: &Scene, resolution: u32) -> Result<Scene, LoadError> {
    // tessellate::tessellate(scene, &TessellationOptions { resolution })
    //     .map_err(|e| error(&scene.name, e.to_string()))
    let message = format!("no tessellation to resolution {resolution} in this build");
    Err(error(&scene.name, message))
}

fn error(spec: &str, message: String) -> LoadError {
    LoadError::Procedural { spec: spec.to_string(), message }
}
