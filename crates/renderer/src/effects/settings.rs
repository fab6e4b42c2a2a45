//! Settings of an image, from the user and the scene.

use scene_loading::{SampleWishes, Scene};

/// How an image is made.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RenderSettings {
    /// Pixels of the image.
    pub resolution: [u32; 2],
    /// Longest chain of rays; eye rays have depth 1.
    pub max_depth: u32,
    /// Numbers of samples that replace those of the scene.
    pub samples: SampleWishes,
    /// Seed of all sample patterns.
    pub seed: u64,
}

impl Default for RenderSettings {
    fn default() -> Self {
        let (resolution, samples) = ([256, 256], SampleWishes::default());
        Self { resolution, max_depth: 5, samples, seed: 1 }
    }
}

/// Numbers of samples: what the settings say, else what the scene says, else 16 (1 for the area
/// of a pixel). Those of effects that are not called for are not used.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Samples {
    /// Eye rays per pixel for its area.
    pub supersamples: u32,
    /// Shadow rays per hit and light with a radius.
    pub shadow: u32,
    /// Rays of the first rough mirror of a path.
    pub glossy: u32,
    /// Eye rays per pixel for the time the shutter is open.
    pub temporal: u32,
    /// Eye rays per pixel for the area of the lens.
    pub focal: u32,
}

impl Samples {
    /// The numbers for a scene.
    pub fn of(scene: &Scene, settings: &RenderSettings) -> Self {
        let (typed, wished) = (settings.samples, scene.samples);
        let number = |typed: Option<u32>, wished: Option<u32>, default: u32| {
            typed.or(wished).unwrap_or(default).max(1)
        };
        Self {
            supersamples: number(typed.supersamples, wished.supersamples, 1),
            shadow: number(typed.shadow, wished.shadow, 16),
            glossy: number(typed.glossy, wished.glossy, 16),
            temporal: number(typed.temporal, wished.temporal, 16),
            focal: number(typed.focal, wished.focal, 16),
        }
    }
}
