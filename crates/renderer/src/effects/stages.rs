//! The stages that an image is traced by. Each takes a whole wave of rays or hits at one dynamic
//! call; which ones there are is decided once, before the first ray ([`crate::effects::plan`]).
//! And the rays that they make, counted by kind and by effect.

use std::ops::Range;

use glam::DVec3;
use scene_loading::Rgb;

use super::effect::Effect;
use crate::rays::RayKind;
use crate::surface::SurfacePoint;

/// Data of a path that are constant from its eye ray on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Origin {
    /// Pixel within the row.
    pub column: u32,
    /// Number of the sample within the pixel: index into its sample patterns.
    pub sample: u32,
    /// Already one of several rays of a rough mirror.
    pub fanned: bool,
    /// When it is, from 0 to the exposure.
    pub time: f64,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EyeRay {
    pub from: DVec3,
    pub direction: DVec3,
    /// The path that it is a part of.
    pub origin: Origin,
    pub share: f64,
}

/// A hit made ready for shading.
#[derive(Debug, Clone, Copy)]
pub struct SurfaceHit<'a> {
    pub point: SurfacePoint<'a>,
    pub id: u32,
    /// Direction of the ray that hit.
    pub incoming: DVec3,
    /// Contribution of the light found here to the pixel.
    pub weight: Rgb,
    pub origin: Origin,
}

/// A question to a light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ShadowRay {
    /// Index of the hit it starts at, within those given.
    pub hit: u32,
    /// The point of the light that it asks, world units.
    pub target: DVec3,
    /// Light that reaches the pixel if unblocked.
    pub light: Rgb,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ScatteredRay {
    /// Index of the hit it starts at, within the wave.
    pub hit: u32,
    pub kind: RayKind,
    pub direction: DVec3,
    /// Contribution of the light that it finds to the pixel.
    pub weight: Rgb,
    pub origin: Origin,
}

/// Rays of an image. Counted by wave, not by ray.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct RayCounts {
    kinds: [u64; 5],
    effects: [u64; Effect::COUNT],
    /// Refracted rays that total internal reflection left untraced.
    pub total_internal_reflections: u64,
}

impl RayCounts {
    pub fn kind(&self, kind: RayKind) -> u64 {
        self.kinds[kind as usize]
    }

    /// Rays that belong to an effect; an eye ray belongs to each effect that it samples.
    pub fn effect(&self, effect: Effect) -> u64 {
        self.effects[effect as usize]
    }

    /// Rays of all kinds.
    pub fn total(&self) -> u64 {
        self.kinds.iter().sum()
    }

    pub fn add_kind(&mut self, kind: RayKind, n: usize) {
        self.kinds[kind as usize] += n as u64;
    }

    pub fn add_effect(&mut self, effect: Effect, n: usize) {
        self.effects[effect as usize] += n as u64;
    }
}

impl std::ops::AddAssign for RayCounts {
    fn add_assign(&mut self, other: Self) {
        let add = |all: &mut [u64], more: &[u64]| {
            all.iter_mut().zip(more).for_each(|(a, b)| *a += b);
        };
        add(&mut self.kinds, &other.kinds);
        add(&mut self.effects, &other.effects);
        self.total_internal_reflections += other.total_internal_reflections;
    }
}

/// Hits of a row of the image, of one depth: 1 for hits of eye rays.
#[derive(Debug, Clone, Copy)]
pub struct Wave<'h> {
    pub y: u32,
    pub depth: u32,
    pub hits: &'h [SurfaceHit<'h>],
}

/// Makes the rays of pixels.
pub trait EyeStage: Send + Sync {
    fn rays_per_pixel(&self) -> u32;
    /// The rays of some columns of row `y`, column by column.
    fn rays(&self, y: u32, columns: Range<u32>, out: &mut Vec<EyeRay>, counts: &mut RayCounts);
}

/// Corrects what hits look like.
pub trait HitStage: Send + Sync {
    fn apply(&self, hits: &mut [SurfaceHit<'_>]);
}

pub trait LightStage: Send + Sync {
    /// Shadow rays per hit, at most.
    fn rays_per_hit(&self) -> usize;
    fn shadow_rays(&self, wave: Wave<'_>, out: &mut Vec<ShadowRay>, counts: &mut RayCounts);
}

pub trait ScatterStage: Send + Sync {
    /// The reflected and refracted rays of a wave.
    fn scatter(&self, wave: Wave<'_>, out: &mut Vec<ScatteredRay>, counts: &mut RayCounts);
}

/// The stages of an image; what is `None` or empty is not there.
pub struct Stages<'a> {
    pub eye: Box<dyn EyeStage>,
    /// Rays that an eye ray may become at once: bounds the size of waves.
    pub fan_out: u32,
    /// Corrections of hits, in order.
    pub hits: Vec<Box<dyn HitStage + 'a>>,
    pub lights: Option<Box<dyn LightStage>>,
    /// Reflection and refraction, if anything does either.
    pub scatter: Option<Box<dyn ScatterStage>>,
}
