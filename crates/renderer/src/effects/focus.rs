//! Depth of field: rays from points of a thin lens through the point of the focal plane that the
//! pinhole's ray goes through.
//!
//! Paper: M. Potmesil, I. Chakravarty, "A Lens and Aperture Camera Model for Synthetic Image
//! Generation", SIGGRAPH 1981; as rays: R. Cook, T. Porter, L. Carpenter, "Distributed Ray
//! Tracing", SIGGRAPH 1984.

use glam::{DVec2, DVec3};
use scene_loading::{Camera, Scene};

use super::effect::{Effect, EffectInfo};
use super::settings::RenderSettings;

pub static INFO: EffectInfo = EffectInfo {
    effect: Effect::Focus,
    name: "depth of field",
    paper: "Potmesil, Chakravarty 1981; Cook, Porter, Carpenter 1984",
    called_by,
};

fn called_by(scene: &Scene, _: &RenderSettings) -> Option<String> {
    let aperture = scene.camera.aperture;
    (aperture > 0.0).then(|| format!("a lens of radius {aperture}"))
}

#[derive(Debug, Clone, Copy)]
pub struct Lens {
    forward: DVec3,
    right: DVec3,
    up: DVec3,
    focal_distance: f64,
}

impl Lens {
    pub fn new(camera: &Camera) -> Self {
        let view = camera.at - camera.from;
        let forward = view.normalize_or(DVec3::NEG_Z);
        let (right, up) = forward.any_orthonormal_pair();
        Self {
            forward,
            right: right * camera.aperture,
            up: up * camera.aperture,
            focal_distance: camera.focal_distance.unwrap_or(view.length()),
        }
    }

    /// The ray through the point `p` of the unit disc that replaces the pinhole's ray.
    pub fn ray(&self, from: DVec3, direction: DVec3, p: DVec2) -> (DVec3, DVec3) {
        let offset = self.right * p.x + self.up * p.y;
        let sharp = direction * (self.focal_distance / direction.dot(self.forward));
        (from + offset, (sharp - offset).normalize_or(direction))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_rays_of_a_pixel_meet_in_the_focal_plane() {
        let camera = Camera { aperture: 0.3, focal_distance: Some(5.0), ..Camera::default() };
        let lens = Lens::new(&camera);
        let direction = DVec3::new(0.2, -0.1, -1.0).normalize();
        let sharp = camera.from + direction * (5.0 / direction.dot(lens.forward));
        for p in [DVec2::ZERO, DVec2::X, DVec2::new(-0.3, 0.8)] {
            let (from, d) = lens.ray(camera.from, direction, p);
            assert!((from - camera.from).length() <= 0.3 + 1e-12);
            let at = from + d * ((sharp - from).dot(d));
            assert!((at - sharp).length() < 1e-12, "{at} {sharp}");
        }
    }
}
