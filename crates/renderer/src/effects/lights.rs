//! Light that comes to a surface straight from a light, by the surface model of NFF, and the stages
//! that ask lights.
//!
//! Papers: A. Appel, "Some Techniques for Shading Machine Renderings of Solids", AFIPS 1968 (hard
//! shadows: one shadow ray per hit and light, no random numbers); R. Cook, T. Porter, L. Carpenter,
//! "Distributed Ray Tracing", SIGGRAPH 1984 (soft ones: shadow rays to points spread over a light
//! with an extent).
//! Deviations: a light is a disc that faces the hit point, as the silhouette of a ball nearly is;
//! every point of it shines alike and, as NFF's lights, without falloff.

use glam::DVec3;
use scene_loading::{Rgb, Scene};

use super::effect::Effect;
use super::sampler::{Pattern, Purpose};
use super::stages::{LightStage, RayCounts, ShadowRay, SurfaceHit, Wave};
use crate::surface::reflect;

/// The lights of a scene: centre, colour and radius.
pub fn lights(scene: &Scene) -> Vec<(DVec3, Rgb, f64)> {
    // SPD's documentation asks for this where a file gives no colours
    let default = [1.0 / (scene.lights.len().max(1) as f64).sqrt(); 3];
    let lights = scene.lights.iter();
    lights.map(|l| (l.position, l.color.unwrap_or(default), l.radius)).collect()
}

/// The side of the surface that lights are seen from.
pub fn lit_normal(hit: &SurfaceHit<'_>, both_sides: bool) -> DVec3 {
    let normal = hit.point.normal;
    if both_sides && normal.dot(hit.incoming) > 0.0 { -normal } else { normal }
}

/// The ray to one point of a light, and the light that comes along it by the surface model of
/// NFF; `None` when the point is not on the lit side.
#[inline(always)]
pub fn shadow_ray(
    hit: &SurfaceHit<'_>,
    index: u32,
    normal: DVec3,
    light: DVec3,
    color: Rgb,
    share: f64,
) -> Option<ShadowRay> {
    let to_light = light - hit.point.position;
    let direction = to_light / to_light.length();
    let cos = normal.dot(direction);
    // NaN: a light in the very point
    if cos.is_nan() || cos <= 0.0 {
        return None;
    }
    let m = hit.point.material;
    let mirror = reflect(hit.incoming, normal).dot(direction).max(0.0);
    let highlight = if m.specular > 0.0 { m.specular * mirror.powf(m.shine) } else { 0.0 };
    let arriving = std::array::from_fn(|k| {
        hit.weight[k] * color[k] * (m.diffuse * hit.point.color[k] * cos + highlight) * share
    });
    Some(ShadowRay { hit: index, target: light, light: arriving })
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

    fn shadow_rays(&self, wave: Wave<'_>, out: &mut Vec<ShadowRay>, counts: &mut RayCounts) {
        let before = out.len();
        for (hit, index) in wave.hits.iter().zip(0..) {
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

    fn shadow_rays(&self, wave: Wave<'_>, out: &mut Vec<ShadowRay>, counts: &mut RayCounts) {
        if wave.depth > 1 {
            return;
        }
        let &Self { light, color, both_sides } = self;
        // a light in the very point has no direction
        let asked = wave.hits.iter().zip(0..).filter(|(hit, _)| hit.point.position != light);
        let before = out.len();
        out.extend(asked.map(|(hit, index)| {
            let lit = shadow_ray(hit, index, lit_normal(hit, both_sides), light, color, 1.0);
            lit.unwrap_or(ShadowRay { hit: index, target: light, light: [0.0; 3] })
        }));
        counts.add_effect(Effect::HardShadows, out.len() - before);
    }
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

    fn shadow_rays(&self, wave: Wave<'_>, out: &mut Vec<ShadowRay>, counts: &mut RayCounts) {
        let share = 1.0 / f64::from(self.samples);
        for (hit, index) in wave.hits.iter().zip(0..) {
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
                let purpose = Purpose::Light(number, wave.depth);
                let pattern = Pattern::new(self.seed, [hit.origin.column, wave.y], purpose);
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
