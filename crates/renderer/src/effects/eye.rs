//! Rays from the eye: one through each pixel, or samples of its area, of the lens and of time.
//!
//! Paper: R. Cook, T. Porter, L. Carpenter, "Distributed Ray Tracing", SIGGRAPH 1984: a pixel's
//! rays are as many as the product of the factors says, and each ray samples all of them at once,
//! so that no factor repeats the positions of another.

use std::ops::Range;

use glam::DVec2;

use super::counts::RayCounts;
use super::effect::Effect;
use super::focus::Lens;
use super::sampler::{Pattern, Purpose};
use super::stages::{EyeRay, EyeStage, Origin};
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

/// Dimensions sampled by a pixel's rays.
#[derive(Debug, Clone, Copy)]
pub struct Sampling {
    pub rays: u32,
    pub lens: Lens,
    /// How long the shutter is open.
    pub shutter: f64,
    /// Seed of the patterns.
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
