//! Shadows of point lights: one shadow ray a hit and light, no random numbers.
//!
//! Paper: A. Appel, "Some Techniques for Shading Machine Renderings of Solids", AFIPS 1968.

use glam::DVec3;
use scene_loading::{Rgb, Scene};

use super::counts::RayCounts;
use super::{Effect, EffectInfo, RenderSettings, counted};
use crate::surface::reflect;
use crate::tracers::stages::{LightStage, Place, ShadowRay, SurfaceHit};

/// Registry line.
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

/// The lights of a scene with their colours.
pub fn lights(scene: &Scene) -> Vec<(DVec3, Rgb)> {
    // SPD's documentation asks for this where a file gives no colours
    let default = [1.0 / (scene.lights.len().max(1) as f64).sqrt(); 3];
    let light = |light: &scene_loading::Light| (light.position(), light.color().unwrap_or(default));
    scene.lights.iter().map(light).collect()
}

/// Asks every light on the lit side.
pub struct PointLights {
    lights: Vec<(DVec3, Rgb)>,
    both_sides: bool,
}

impl PointLights {
    /// The centres of all lights. `both_sides` lights the side that is seen, else the outer one.
    pub fn new(scene: &Scene, both_sides: bool) -> Self {
        Self { lights: lights(scene), both_sides }
    }
}

impl LightStage for PointLights {
    fn rays_a_hit(&self) -> usize {
        self.lights.len()
    }

    fn shadow_rays(
        &self,
        _: Place,
        hits: &[SurfaceHit<'_>],
        out: &mut Vec<ShadowRay>,
        counts: &mut RayCounts,
    ) {
        let before = out.len();
        for (hit, index) in hits.iter().zip(0..) {
            let normal = lit_normal(hit, self.both_sides);
            for &(light, color) in &self.lights {
                out.extend(shadow_ray(hit, index, normal, light, color, 1.0));
            }
        }
        counts.add_effect(Effect::HardShadows, out.len() - before);
    }
}

/// Asks the first light from every primary hit, lit side or not; see
/// [`ShadowRays::FirstLight`](crate::rays::ShadowRays::FirstLight). None in a scene without lights.
pub fn first_light(scene: &Scene, both_sides: bool) -> Option<Box<dyn LightStage>> {
    let &(light, color) = lights(scene).first()?;
    Some(Box::new(FirstLight { light, color, both_sides }))
}

struct FirstLight {
    light: DVec3,
    color: Rgb,
    both_sides: bool,
}

impl LightStage for FirstLight {
    fn rays_a_hit(&self) -> usize {
        1
    }

    fn shadow_rays(
        &self,
        place: Place,
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
