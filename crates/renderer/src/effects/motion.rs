//! Motion blur: every eye ray has a time within the exposure, and its path sees moving
//! primitives where they are then.
//!
//! Paper: R. Cook, T. Porter, L. Carpenter, "Distributed Ray Tracing", SIGGRAPH 1984.
//! Deviations: primitives move in a straight line at constant speed; eye and lights are at rest.

use glam::DVec3;
use scene_loading::Scene;

use super::effect::{Effect, EffectInfo, counted};
use super::settings::RenderSettings;
use super::stages::{HitStage, SurfaceHit};
use crate::shading::surface::Surfaces;

pub static INFO: EffectInfo = EffectInfo {
    effect: Effect::Motion,
    name: "motion blur",
    paper: "Cook, Porter, Carpenter 1984",
    called_by,
};

fn called_by(scene: &Scene, _: &RenderSettings) -> Option<String> {
    let moving = scene.velocities.iter().filter(|v| **v != DVec3::ZERO).count();
    let shutter = scene.camera.shutter;
    let is_called = moving > 0 && shutter > 0.0;
    let moving = counted(moving, "moving primitive");
    is_called.then(|| format!("{moving}, a shutter open for {shutter}"))
}

/// Looks up the surfaces of moving primitives where they are at rest.
pub struct MovedSurfaces<'a> {
    scene: &'a Scene,
    surfaces: Surfaces<'a>,
}

impl<'a> MovedSurfaces<'a> {
    pub fn new(scene: &'a Scene) -> Self {
        Self { scene, surfaces: Surfaces::new(scene, false) }
    }
}

impl HitStage for MovedSurfaces<'_> {
    fn apply(&self, hits: &mut [SurfaceHit<'_>]) {
        for hit in hits {
            let velocity = self.scene.velocity(hit.id);
            if velocity != DVec3::ZERO {
                let way = velocity * hit.origin.time;
                let at_rest = self.surfaces.at(hit.id, hit.point.position - way);
                hit.point.normal = at_rest.normal;
                hit.point.refined = at_rest.refined.moved_by(way);
            }
        }
    }
}
