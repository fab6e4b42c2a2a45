//! Parts shared by the generators: sky, fixed parts of the view, surface kinds.

use glam::{DMat3, DVec3};

use crate::scene::{Camera, Light, Material, NO_HIGHLIGHT, Rgb, Scene};

/// Background of every SPD scene.
const SKY: Rgb = [0.078, 0.361, 0.753];

pub(crate) const Y_UP: [f64; 3] = [0.0, 1.0, 0.0];
pub(crate) const Z_UP: [f64; 3] = [0.0, 0.0, 1.0];

/// A view of 512 by 512 pixels; `angle` is the full field of view, degrees.
pub(crate) fn view(from: [f64; 3], at: [f64; 3], up: [f64; 3], angle: f64, hither: f64) -> Camera {
    let [from, at, up] = [from, at, up].map(DVec3::from_array);
    Camera { from, at, up, angle, hither, resolution: [512, 512], ..Camera::default() }
}

/// A scene with view, sky and uncoloured point lights, without primitives.
pub(crate) fn stage(camera: Camera, lights: &[[f64; 3]]) -> Scene {
    Scene {
        camera,
        background: SKY,
        lights: lights.iter().map(|&p| Light::point(DVec3::from_array(p), None)).collect(),
        ..Scene::default()
    }
}

/// An opaque surface without highlight. The files give such surfaces the index of refraction 0.
pub(crate) fn matte(color: Rgb) -> Material {
    Material { color, shine: NO_HIGHLIGHT, refraction_index: 0.0, ..Material::default() }
}

/// An opaque surface with a highlight that has fallen to one half at `half_angle` degrees.
pub(crate) fn glossy(color: Rgb, diffuse: f64, specular: f64, half_angle: f64) -> Material {
    Material { diffuse, specular, shine: phong_exponent(half_angle), ..matte(color) }
}

/// The exponent `e` with `cos(half_angle)^e = 1/2`; the angle is in degrees, between 0 and 90.
pub(crate) fn phong_exponent(half_angle: f64) -> f64 {
    0.5_f64.ln() / half_angle.to_radians().cos().ln()
}

/// Corners of the square `|x|, |y| <= half` at height `z`, from `+ +` on, against the clock as
/// seen from above.
pub(crate) fn ground(half: f64, z: f64) -> [DVec3; 4] {
    [[half, half], [-half, half], [-half, -half], [half, -half]].map(|[x, y]| DVec3::new(x, y, z))
}

/// Rotation by `angle` (radians) about `axis` (any length but 0).
pub(crate) fn rotation(axis: DVec3, angle: f64) -> DMat3 {
    DMat3::from_axis_angle(axis / axis.length(), angle)
}
