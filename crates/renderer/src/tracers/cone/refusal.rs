//! Scenes that cone tracing does not support: motion, lenses and rough mirrors.

use glam::DVec3;
use scene_loading::Scene;

use super::settings::INFO;
use crate::tracers::info::Refusal;

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
