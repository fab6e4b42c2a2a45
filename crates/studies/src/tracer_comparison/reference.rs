//! The image to compare with: many samples per pixel, of two seeds, so that its own error is known.

use accel_core::query::tracer::Tracer;
use renderer::{EffectPlan, Image, RenderSettings, render_plan};
use scene_loading::{SampleWishes, Scene};

use crate::image_error::ConvergedImage;

/// The converged image of a scene: two images of `samples` a pixel, in the current rayon pool.
/// The seeds are none that a measured image has.
pub fn converged(
    scene: &Scene,
    tracer: &dyn Tracer<f32>,
    frame: Sampled,
    samples: u32,
) -> ConvergedImage {
    let image = |seed| frame.image(scene, tracer, samples, seed);
    let first = image(frame.seed ^ 0x5265_6665_7265_6e63);
    ConvergedImage::of(&first, &image(frame.seed ^ 0x6552_6665_7265_6e63))
}

/// An image by samples: size, depth, and the seed of its patterns.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Sampled {
    /// Width and height in pixels.
    pub resolution: [u32; 2],
    /// Longest chain of rays.
    pub max_depth: u32,
    pub seed: u64,
}

impl Sampled {
    /// The plan of an image with that many eye rays per pixel; what has a lens, a shutter or a
    /// light with an extent has one sample of each for every eye ray.
    pub fn plan(&self, scene: &Scene, samples: u32, seed: u64) -> EffectPlan {
        let samples = SampleWishes { supersamples: Some(samples), ..SampleWishes::ONE_OF_EACH };
        let (resolution, max_depth) = (self.resolution, self.max_depth);
        EffectPlan::of(scene, &RenderSettings { resolution, max_depth, samples, seed })
    }

    fn image(&self, scene: &Scene, tracer: &dyn Tracer<f32>, samples: u32, seed: u64) -> Image {
        render_plan(scene, tracer, &self.plan(scene, samples, seed)).image
    }
}
