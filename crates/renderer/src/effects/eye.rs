//! Rays from the eye: one through each pixel, or samples of its area, of the lens and of time.
//!
//! Paper: R. Cook, T. Porter, L. Carpenter, "Distributed Ray Tracing", SIGGRAPH 1984: a pixel's
//! rays are as many as the product of the factors says, and each ray samples all of them at once,
//! so that no factor repeats the positions of another. Depth of field: M. Potmesil, I. Chakravarty,
//! "A Lens and Aperture Camera Model for Synthetic Image Generation", SIGGRAPH 1981, as rays from
//! points of a thin lens through the point of the focal plane that the pinhole's ray goes through.
//! The area of a pixel: T. Whitted 1980 and R. Cook, "Stochastic Sampling in Computer Graphics", ACM
//! TOG 5(1), 1986, averaged by a box filter. Deviation: a low-discrepancy pattern instead of jitter.

use std::ops::Range;

use glam::{DVec2, DVec3};
use scene_loading::Camera;

use super::effect::Effect;
use super::sampler::{Pattern, Purpose};
use super::stages::{EyeRay, EyeStage, Origin, RayCounts};
use crate::camera::EyeRays;
use crate::rays::RayKind;

/// One ray per pixel, no random numbers.
pub struct Pinhole(pub EyeRays);

impl EyeStage for Pinhole {
    fn rays_per_pixel(&self) -> u32 {
        1
    }

    fn rays(&self, y: u32, columns: Range<u32>, out: &mut Vec<EyeRay>, counts: &mut RayCounts) {
        counts.add_kind(RayKind::Primary, columns.len());
        out.extend(columns.map(|column| EyeRay {
            from: self.0.origin(),
            direction: self.0.direction(column, y),
            origin: Origin { column, sample: 0, fanned: false, time: 0.0 },
            share: 1.0,
        }));
    }
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

/// Dimensions sampled by a pixel's rays.
#[derive(Debug, Clone, Copy)]
pub struct Sampling {
    pub rays: u32,
    pub lens: Lens,
    /// How long the shutter is open.
    pub shutter: f64,
    pub seed: u64,
}

/// Several rays per pixel. What is not sampled is not compiled in.
pub struct SampledEye<const AREA: bool, const LENS: bool, const TIME: bool> {
    eye: EyeRays,
    sampling: Sampling,
}

/// The stage that samples what the three flags say.
pub fn sampled(eye: EyeRays, sampling: Sampling, flags: [bool; 3]) -> Box<dyn EyeStage> {
    macro_rules! stage {
        ($area:literal, $lens:literal, $time:literal) => {
            Box::new(SampledEye::<$area, $lens, $time> { eye, sampling })
        };
    }
    match flags {
        [false, false, false] => Box::new(Pinhole(eye)),
        [false, false, true] => stage!(false, false, true),
        [false, true, false] => stage!(false, true, false),
        [false, true, true] => stage!(false, true, true),
        [true, false, false] => stage!(true, false, false),
        [true, false, true] => stage!(true, false, true),
        [true, true, false] => stage!(true, true, false),
        [true, true, true] => stage!(true, true, true),
    }
}

impl<const AREA: bool, const LENS: bool, const TIME: bool> EyeStage
    for SampledEye<AREA, LENS, TIME>
{
    fn rays_per_pixel(&self) -> u32 {
        self.sampling.rays
    }

    fn rays(&self, y: u32, columns: Range<u32>, out: &mut Vec<EyeRay>, counts: &mut RayCounts) {
        let Sampling { rays, ref lens, shutter, seed } = self.sampling;
        let share = 1.0 / f64::from(rays);
        let n = columns.len() * rays as usize;
        counts.add_kind(RayKind::Primary, n);
        for (effect, is_sampled) in
            [(Effect::Supersampling, AREA), (Effect::Focus, LENS), (Effect::Motion, TIME)]
        {
            counts.add_effect(effect, if is_sampled { n } else { 0 });
        }
        for column in columns {
            let pattern = |purpose| Pattern::new(seed, [column, y], purpose);
            let [area, disc, line] = [Purpose::Pixel, Purpose::Lens, Purpose::Time].map(pattern);
            for sample in 0..rays {
                let within = if AREA { area.square(sample) } else { DVec2::splat(0.5) };
                let mut from = self.eye.origin();
                let mut direction = self.eye.direction_within(column, y, within);
                if LENS {
                    (from, direction) = lens.ray(from, direction, disc.disc(sample));
                }
                let time = if TIME { shutter * line.line(sample) } else { 0.0 };
                let origin = Origin { column, sample, fanned: false, time };
                out.push(EyeRay { from, direction, origin, share });
            }
        }
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
