//! Shadows of point lights: one shadow ray per hit and light, no random numbers.
//!
//! Paper: A. Appel, "Some Techniques for Shading Machine Renderings of Solids", AFIPS 1968.

use glam::DVec3;
use scene_loading::{Rgb, Scene};

use super::counts::RayCounts;
use super::direct_light::{lights, lit_normal, shadow_ray};
use super::effect::{Effect, EffectInfo, counted};
use super::settings::RenderSettings;
use super::stages::{LightStage, ShadowRay, SurfaceHit, WavePosition};

pub static INFO: EffectInfo = EffectInfo {
    effect: Effect::HardShadows,
    name: "hard shadows",
    paper: "Appel 1968",
    called_by,
};

fn called_by(scene: &Scene, _: &RenderSettings) -> Option<String> {
    let points = scene.lights.iter().filter(|light| light.radius() <= 0.0).count();
    (points > 0).then(|| format!("{} without a radius", counted(points, "light")))
}

/// Asks every light on the lit side.
pub struct PointLights {
    lights: Vec<(DVec3, Rgb, f64)>,
    both_sides: bool,
}

impl PointLights {
    /// The centres of all lights. `both_sides` lights the side that is seen, else the outer one.
    pub fn new(scene: &Scene, both_sides: bool) -> Self {
        Self { lights: lights(scene), both_sides }
    }
}

impl LightStage for PointLights {
    fn rays_per_hit(&self) -> usize {
        self.lights.len()
    }

    fn shadow_rays(
        &self,
        _: WavePosition,
        hits: &[SurfaceHit<'_>],
        out: &mut Vec<ShadowRay>,
        counts: &mut RayCounts,
    ) {
        let before = out.len();
        for (hit, index) in hits.iter().zip(0..) {
            let normal = lit_normal(hit, self.both_sides);
            for &(light, color, _) in &self.lights {
                out.extend(shadow_ray(hit, index, normal, light, color, 1.0));
            }
        }
        counts.add_effect(Effect::HardShadows, out.len() - before);
    }
}

/// Asks the first light from every primary hit, lit side or not; see
/// [`ShadowRays::FirstLight`](crate::rays::ShadowRays::FirstLight). None in a scene without lights.
pub fn first_light(scene: &Scene, both_sides: bool) -> Option<Box<dyn LightStage>> {
    let &(light, color, _) = lights(scene).first()?;
    Some(Box::new(FirstLight { light, color, both_sides }))
}

struct FirstLight {
    light: DVec3,
    color: Rgb,
    both_sides: bool,
}

impl LightStage for FirstLight {
    fn rays_per_hit(&self) -> usize {
        1
    }

    fn shadow_rays(
        &self,
        place: WavePosition,
        hits: &[SurfaceHit<'_>],
        out: &mut Vec<ShadowRay>,
        counts: &mut RayCounts,
    ) {
        if place.depth > 1 {
            return;
        }
        let &Self { light, color, both_sides } = self;
        // a light in the very point has no direction
        let asked = hits.iter().zip(0..).filter(|(hit, _)| hit.point.position != light);
        let before = out.len();
        out.extend(asked.map(|(hit, index)| {
            let lit = shadow_ray(hit, index, lit_normal(hit, both_sides), light, color, 1.0);
            lit.unwrap_or(ShadowRay { hit: index, target: light, light: [0.0; 3] })
        }));
        counts.add_effect(Effect::HardShadows, out.len() - before);
    }
}
