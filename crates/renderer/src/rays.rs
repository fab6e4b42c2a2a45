//! The rays of a scene by kind, produced once and replayed to every structure.

use accel_core::Ray;
use accel_core::registry::Buildable;

use crate::ray_offset::OffsetRule;

#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum RayKind {
    Primary,
    /// From a hit point to a light: a question of occlusion.
    Shadow,
    Reflected,
    /// Into or out of a transmissive body.
    Refracted,
    /// One cosine-distributed bounce for each primary hit: incoherent rays, in every scene.
    Diffuse,
}

impl RayKind {
    pub const ALL: [Self; 5] =
        [Self::Primary, Self::Shadow, Self::Reflected, Self::Refracted, Self::Diffuse];

    pub fn name(self) -> &'static str {
        match self {
            Self::Primary => "primary",
            Self::Shadow => "shadow",
            Self::Reflected => "reflected",
            Self::Refracted => "refracted",
            Self::Diffuse => "diffuse",
        }
    }

    /// Summary in one line.
    pub fn summary(self) -> &'static str {
        match self {
            Self::Primary => "from the eye; closest hit",
            Self::Shadow => "from a hit point to each light it faces; occlusion by opaque things",
            Self::Reflected => "mirror direction at specular or transmissive surfaces; closest hit",
            Self::Refracted => "through transmissive surfaces by Snell's law; closest hit",
            Self::Diffuse => "one cosine-distributed bounce per primary hit; closest hit",
        }
    }

    /// True when the question is occlusion, not the closest hit.
    pub fn is_occlusion(self) -> bool {
        self == Self::Shadow
    }
}

#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum ShadowRays {
    /// From every hit to each light on the lit side, as an image needs them.
    #[default]
    EachLight,
    /// From every primary hit one to the first light, whichever side it is on: as many as primary
    /// rays hit something, so that scenes with many lights weigh no more than others.
    FirstLight,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RaySettings {
    /// Pixels of the image.
    pub resolution: [u32; 2],
    /// Longest chain of closest-hit rays; eye rays have depth 1.
    pub max_depth: u32,
    /// The rules of Havran and Sixta (1999) where they differ from ours: corner rays, normals not
    /// flipped to the viewer, their cone normal.
    pub historical: bool,
    /// Rule that keeps a ray off the surface it leaves.
    pub offset: OffsetRule,
    /// Also make the diffuse bounce set.
    pub diffuse: bool,
    pub seed: u64,
    pub shadows: ShadowRays,
}

impl Default for RaySettings {
    fn default() -> Self {
        Self {
            resolution: [256, 256],
            max_depth: 5,
            historical: false,
            offset: OffsetRule::default(),
            diffuse: true,
            seed: 1,
            shadows: ShadowRays::default(),
        }
    }
}

impl RaySettings {
    /// The setting of Havran and Sixta (1999): 513 x 513 eye rays, depth 5, an epsilon of 0.01
    /// world units, no diffuse set.
    pub fn published() -> Self {
        Self {
            resolution: [512, 512],
            max_depth: 5,
            historical: true,
            offset: OffsetRule::Fixed(0.01),
            diffuse: false,
            ..Self::default()
        }
    }
}

/// Rays by kind, in scanline order.
#[derive(Debug, Clone, Default)]
pub struct RayBatches<S: Buildable> {
    batches: [Vec<Ray<S>>; 5],
    /// Refracted rays that total internal reflection left untraced; Havran and Sixta count them.
    pub total_internal_reflections: u64,
}

impl<S: Buildable> RayBatches<S> {
    pub fn rays(&self, kind: RayKind) -> &[Ray<S>] {
        &self.batches[kind as usize]
    }

    pub fn total(&self) -> usize {
        self.batches.iter().map(Vec::len).sum()
    }

    pub(crate) fn batch_mut(&mut self, kind: RayKind) -> &mut Vec<Ray<S>> {
        &mut self.batches[kind as usize]
    }

    pub(crate) fn append(&mut self, mut other: Self) {
        for (all, more) in self.batches.iter_mut().zip(&mut other.batches) {
            all.append(more);
        }
    }
}
