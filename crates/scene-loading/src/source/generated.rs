//! The one place where the catalogue calls the generators and the tessellator.

use crate::error::LoadError;
use crate::procedural;
use crate::scene::Scene;
use crate::tessellate::{TessellationOptions, tessellate as into_triangles};

/// The names of the generators.
pub(crate) fn families() -> Vec<&'static str> {
    procedural::generators().map(|entry| entry.name).collect()
}

/// Generates `balls` or `balls:5`.
pub(crate) fn generate(spec: &str) -> Result<Scene, LoadError> {
    procedural::generate(spec).map_err(|e| error(spec, e.to_string()))
}

/// Turns spheres, cones and polygons into triangles.
pub(crate) fn tessellate(scene: &Scene, resolution: u32) -> Result<Scene, LoadError> {
    into_triangles(scene, &TessellationOptions { resolution })
        .map_err(|e| error(&scene.name, e.to_string()))
}

fn error(spec: &str, message: String) -> LoadError {
    LoadError::Procedural { spec: spec.to_string(), message }
}
