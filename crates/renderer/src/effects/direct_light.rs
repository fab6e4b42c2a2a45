//! Light that comes to a surface straight from a light, by the surface model of NFF.

use glam::DVec3;
use scene_loading::{Rgb, Scene};

use super::stages::{ShadowRay, SurfaceHit};
use crate::shading::surface::reflect;

/// The lights of a scene: centre, colour and radius.
pub fn lights(scene: &Scene) -> Vec<(DVec3, Rgb, f64)> {
    // SPD's documentation asks for this where a file gives no colours
    let default = [1.0 / (scene.lights.len().max(1) as f64).sqrt(); 3];
    let lights = scene.lights.iter();
    lights.map(|l| (l.position(), l.color().unwrap_or(default), l.radius())).collect()
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
