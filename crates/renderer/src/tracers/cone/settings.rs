//! Settings of cone tracing, and the scenes that it does not support: motion, lenses and rough
//! mirrors.

use glam::DVec3;
use scene_loading::Scene;

use crate::tracers::info::{Refusal, TracerInfo};

pub static INFO: TracerInfo = TracerInfo {
    name: "cone",
    summary: "one cone per pixel: covered areas instead of samples, also for soft shadows",
    paper: "Amanatides 1984",
    assumptions: "a pixel is a disc; a surface is shaded at the middle of its visible part; \
                  cones stay round; shares of outlines that still overlap are estimated",
    deviations: "exact areas; cut into four where the estimate fails; oblique reflection; sides of \
                 truncated cones",
    refuses: "motion, a lens, rough mirrors",
};

/// How cones are traced.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// How often a cone is cut into four where its estimate fails; 0 is the paper's plain estimate.
    pub subdivisions: u32,
    /// A cone is cut where the normal turns by more than this across its footprint, radians.
    pub turn: f64,
    /// Radius of a pixel's cone over that of a disc with the pixel's area; 0 traces rays.
    pub width: f64,
    /// True if curved surfaces change the spread of a cone. Without, reflections are wrong: it
    /// shows what that is worth.
    pub widening: bool,
    /// Cones that contribute less than this part of a pixel go on as rays; those from surfaces
    /// within one cone as one ray.
    pub ray_below: f64,
}

impl Default for Settings {
    fn default() -> Self {
        Self { subdivisions: 2, turn: 0.5, width: 1.0, widening: true, ray_below: 1.0 / 64.0 }
    }
}

/// Checks that cones can draw the scene.
///
/// # Errors
/// [`Refusal`] for what moves while the shutter is open, a lens with an extent and rough mirrors.
pub fn refusal(scene: &Scene) -> Result<(), Refusal> {
    let moving = scene.velocities.iter().take(scene.primitives.len());
    let moving = moving.filter(|v| **v != DVec3::ZERO && scene.camera.shutter > 0.0).count();
    Refusal::of(&INFO, scene, moving, "primitives that move while the shutter is open")?;
    let lenses = usize::from(scene.camera.aperture > 0.0);
    Refusal::of(&INFO, scene, lenses, "lens with an extent")?;
    let is_rough = |p: &&scene_loading::Primitive| {
        let material = scene.materials.get(p.material as usize);
        material.is_some_and(|m| m.specular > 0.0 && m.roughness > 0.0)
    };
    let rough = scene.primitives.iter().filter(is_rough).count();
    Refusal::of(&INFO, scene, rough, "primitives with a rough mirror")
}
