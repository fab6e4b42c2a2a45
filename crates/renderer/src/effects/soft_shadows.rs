//! Shadows of lights with an extent: shadow rays to points spread over the light.
//!
//! Paper: R. Cook, T. Porter, L. Carpenter, "Distributed Ray Tracing", SIGGRAPH 1984.
//! Deviations: a light is a disc that faces the hit point, as the silhouette of a ball nearly is;
//! every point of it shines alike and, as NFF's lights, without falloff.

use glam::DVec3;
use scene_loading::{Rgb, Scene};

use super::counts::RayCounts;
use super::direct_light::{lights, lit_normal, shadow_ray};
use super::effect::{Effect, EffectInfo, counted};
use super::sampler::{Pattern, Purpose};
use super::settings::RenderSettings;
use super::stages::{LightStage, ShadowRay, SurfaceHit, WavePosition};

pub static INFO: EffectInfo = EffectInfo {
    effect: Effect::SoftShadows,
    name: "soft shadows",
    paper: "Cook, Porter, Carpenter 1984",
    called_by,
};

fn called_by(scene: &Scene, _: &RenderSettings) -> Option<String> {
    let discs = scene.lights.iter().filter(|light| light.radius() > 0.0).count();
    (discs > 0).then(|| format!("{} with a radius", counted(discs, "light")))
}

/// Asks point lights once and others at several points.
pub struct DiscLights {
    lights: Vec<(DVec3, Rgb, f64)>,
    samples: u32,
    seed: u64,
}

impl DiscLights {
    /// All lights; `samples` shadow rays for each that has a radius.
    pub fn new(scene: &Scene, samples: u32, seed: u64) -> Self {
        Self { lights: lights(scene), samples, seed }
    }
}

impl LightStage for DiscLights {
    fn rays_per_hit(&self) -> usize {
        self.lights.len().saturating_mul(self.samples as usize)
    }

    fn shadow_rays(
        &self,
        place: WavePosition,
        hits: &[SurfaceHit<'_>],
        out: &mut Vec<ShadowRay>,
        counts: &mut RayCounts,
    ) {
        let share = 1.0 / f64::from(self.samples);
        for (hit, index) in hits.iter().zip(0..) {
            let normal = lit_normal(hit, true);
            for (&(light, color, radius), number) in self.lights.iter().zip(0..) {
                let before = out.len();
                if radius <= 0.0 {
                    out.extend(shadow_ray(hit, index, normal, light, color, 1.0));
                    counts.add_effect(Effect::HardShadows, out.len() - before);
                    continue;
                }
                let axis = (light - hit.point.position).normalize_or(normal);
                let (s, t) = axis.try_normalize().unwrap_or(DVec3::Z).any_orthonormal_pair();
                let purpose = Purpose::Light(number, place.depth);
                let pattern = Pattern::new(self.seed, [hit.origin.column, place.y], purpose);
                let begin = hit.origin.sample.wrapping_mul(self.samples);
                for k in 0..self.samples {
                    let p = pattern.disc(begin.wrapping_add(k)) * radius;
                    let at = light + s * p.x + t * p.y;
                    out.extend(shadow_ray(hit, index, normal, at, color, share));
                }
                counts.add_effect(Effect::SoftShadows, out.len() - before);
            }
        }
    }
}
