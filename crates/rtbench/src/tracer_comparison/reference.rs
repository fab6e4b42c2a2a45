//! The image to compare with: many samples a pixel, of two seeds, so that its own error is known.

use accel_core::tracer::Tracer;
use renderer::{EffectPlan, Image, RenderSettings, render_plan};
use scene_loading::{SampleWishes, Scene};

use super::image_error::rmse;

/// A row's error must be this many times that of the reference to be told from it.
const MARGIN: f64 = 10.0;

/// A converged image.
#[derive(Debug, Clone, PartialEq)]
pub struct Reference {
    /// The mean of two images of unlike seeds.
    pub image: Image,
    /// Its own error: half the root mean square difference of the two.
    pub own_error: f64,
    /// Samples a pixel, of each of the two.
    pub samples: u32,
}

impl Reference {
    /// Two images of `samples` a pixel, in the current rayon pool. The seeds are none that a
    /// measured image has.
    pub fn of(scene: &Scene, tracer: &dyn Tracer<f32>, frame: Sampled, samples: u32) -> Self {
        let image = |seed| frame.image(scene, tracer, samples, seed);
        let first = image(frame.seed ^ 0x5265_6665_7265_6e63);
        let second = image(frame.seed ^ 0x6552_6665_7265_6e63);
        let own_error = rmse(&first, &second).unwrap_or(f64::NAN) / 2.0;
        let mean = |(a, b): (&[f64; 3], &[f64; 3])| std::array::from_fn(|k| (a[k] + b[k]) / 2.0);
        let pixels = first.pixels.iter().zip(&second.pixels).map(mean).collect();
        Self { image: Image { pixels, ..first }, own_error, samples }
    }

    /// Whether an error is so small that much of it may be that of the reference itself.
    pub fn hides(&self, error: f64) -> bool {
        self.own_error * MARGIN > error
    }
}

/// An image by samples: size, depth, and the seed of its patterns.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Sampled {
    /// Width and height in pixels.
    pub resolution: [u32; 2],
    /// Longest chain of rays.
    pub max_depth: u32,
    /// Seed.
    pub seed: u64,
}

impl Sampled {
    /// The plan of an image with that many eye rays a pixel; what has a lens, a shutter or a light
    /// with an extent has one sample of each for every eye ray.
    pub fn plan(&self, scene: &Scene, samples: u32, seed: u64) -> EffectPlan {
        let once = Some(1);
        let samples = SampleWishes {
            supersamples: Some(samples),
            shadow: once,
            glossy: once,
            temporal: once,
            focal: once,
        };
        let (resolution, max_depth) = (self.resolution, self.max_depth);
        EffectPlan::of(scene, &RenderSettings { resolution, max_depth, samples, seed })
    }

    fn image(&self, scene: &Scene, tracer: &dyn Tracer<f32>, samples: u32, seed: u64) -> Image {
        render_plan(scene, tracer, &self.plan(scene, samples, seed)).image
    }
}
