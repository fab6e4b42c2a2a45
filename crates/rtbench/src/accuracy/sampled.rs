//! Images with samples: their errors, and the reference they are held against.
//!
//! The reference is the mean of two images of many samples with different seeds; its own error is
//! half the distance between the two. Errors that are not ten times that are not told from it.

use accel_core::tracer::Tracer;
use renderer::{EffectPlan, Image, RenderSettings, render_plan};
use scene_loading::{SampleWishes, Scene};

use crate::accuracy::audit;
use crate::accuracy::error_of::ErrorOf;
use crate::accuracy::record::SceneOutcome;
use crate::accuracy::stage::Stage;
use crate::accuracy::timing::{Said, Variant, Work, timed};
use crate::commands::render::plan_of;
use crate::error::Error;
use crate::pools::pool;
use rayon::ThreadPool;

/// Images of a variant with seeds of their own, over which errors are averaged.
const SEEDS: u64 = 3;

/// How an experiment samples.
#[derive(Debug, Clone, Copy)]
pub struct Plan {
    /// Pixels of the image, an axis.
    pub size: u32,
    /// Samples of the variants.
    pub samples: &'static [u32],
    /// Samples of each image of the reference.
    pub reference: u32,
}

impl Plan {
    /// Of a full run, or of a quick one.
    pub fn new(quick: bool) -> Self {
        match quick {
            true => Self { size: 12, samples: &[1, 4, 16], reference: 512 },
            false => Self { size: 24, samples: &[1, 4, 16, 64, 256], reference: 8192 },
        }
    }
}

/// A sampled effect of a scene, and who traces it.
pub struct Sampled<'a> {
    /// The scene, the effect put on.
    pub scene: &'a Scene,
    /// Who traces it.
    pub tracer: &'a dyn Tracer<f32>,
    /// Longest chain of rays.
    pub max_depth: u32,
    /// Sets the number of samples.
    pub wish: fn(&mut SampleWishes, u32),
    /// How to have a number of samples without this command.
    pub option: &'static str,
}

impl Sampled<'_> {
    fn plan(&self, size: u32, samples: u32, seed: u64) -> Result<EffectPlan, Error> {
        let mut wishes = SampleWishes {
            supersamples: Some(1),
            shadow: Some(1),
            glossy: Some(1),
            temporal: Some(1),
            focal: Some(1),
        };
        (self.wish)(&mut wishes, samples);
        let settings = RenderSettings {
            resolution: [size; 2],
            max_depth: self.max_depth,
            samples: wishes,
            seed,
        };
        Ok(plan_of(self.scene, &settings)?)
    }

    fn image(&self, size: u32, samples: u32, seed: u64) -> Result<Image, Error> {
        Ok(render_plan(self.scene, self.tracer, &self.plan(size, samples, seed)?).image)
    }

    /// All numbers of samples, judged and timed.
    ///
    /// # Errors
    /// [`Error`] for more samples than fit, or threads that cannot be started.
    pub fn measured(&self, stage: &Stage<'_>) -> Result<SceneOutcome, Error> {
        let plan = Plan::new(stage.quick);
        let one_thread = pool(1)?;
        // seeds that no variant has
        let far = |i: u64| stage.seed.wrapping_mul(1009).wrapping_add(100_000 + i);
        let [a, b] = [
            self.image(plan.size, plan.reference, far(0))?,
            self.image(plan.size, plan.reference, far(1))?,
        ];
        let (reference, own) = (mean(&a, &b), rmse(&a, &b) / 2.0);
        let mut faults = Vec::new();
        let mut variants = Vec::new();
        for &n in plan.samples {
            let seeds = (0..SEEDS).map(|i| stage.seed.wrapping_mul(31).wrapping_add(i));
            let images = seeds
                .map(|seed| self.image(plan.size, n, seed))
                .collect::<Result<Vec<Image>, Error>>()?;
            let squares: f64 = images.iter().map(|i| rmse(i, &reference).powi(2)).sum();
            let error = (squares / SEEDS as f64).sqrt();
            if let ([.., c, d], true) = (images.as_slice(), Some(&n) == plan.samples.last()) {
                let scatter = rmse(c, d) / 2.0_f64.sqrt();
                faults.extend(audit::bad_reference(error, scatter, own));
            }
            variants.push(Variant {
                name: format!("{n} samples"),
                setting: format!("render {}={n}", self.option),
                known_defect: None,
                is_reference: false,
                error: ErrorOf::Rmse { rmse: error },
                also: vec![("samples", f64::from(n))],
                work: Box::new(Rendering {
                    scene: self.scene,
                    tracer: self.tracer,
                    plan: self.plan(plan.size, n, stage.seed)?,
                    pool: &one_thread,
                    image: None,
                }),
            });
        }
        let said = Said {
            timed: format!("the image of {0} x {0} pixels, one thread", plan.size),
            judged: format!(
                "the mean square over {SEEDS} seeds; reference: 2 x {} samples",
                plan.reference
            ),
            reference_error: own,
            faults,
        };
        Ok(timed(stage, said, variants))
    }
}

/// An image that is made again and again.
pub struct Rendering<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// Who traces it.
    pub tracer: &'a dyn Tracer<f32>,
    /// Its effects.
    pub plan: EffectPlan,
    /// Where it is made.
    pub pool: &'a ThreadPool,
    /// The last one.
    pub image: Option<Image>,
}

impl Work for Rendering<'_> {
    fn prepare(&mut self) {
        self.image = None;
    }

    fn run(&mut self) {
        let image = self.pool.install(|| render_plan(self.scene, self.tracer, &self.plan).image);
        self.image = Some(image);
    }

    fn fingerprint(&self) -> u64 {
        use std::hash::{DefaultHasher, Hash, Hasher};
        let mut hasher = DefaultHasher::new();
        let pixels = self.image.iter().flat_map(|image| image.pixels.as_flattened());
        pixels.for_each(|x| x.to_bits().hash(&mut hasher));
        hasher.finish()
    }
}

/// Pixel by pixel.
fn mean(a: &Image, b: &Image) -> Image {
    let mut mean = a.clone();
    let all = mean.pixels.as_flattened_mut().iter_mut();
    all.zip(b.pixels.as_flattened()).for_each(|(x, y)| *x = (*x + y) / 2.0);
    mean
}

/// Root of the mean square of the differences, over all pixels and channels.
pub fn rmse(a: &Image, b: &Image) -> f64 {
    let (a, b) = (a.pixels.as_flattened(), b.pixels.as_flattened());
    let squares: f64 = a.iter().zip(b).map(|(x, y)| (x - y) * (x - y)).sum();
    (squares / a.len().max(1) as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_and_means_of_images() {
        let image = |x: f64| Image { width: 1, height: 2, pixels: vec![[x; 3]; 2] };
        assert_eq!(rmse(&image(1.0), &image(1.5)), 0.5);
        assert_eq!(mean(&image(1.0), &image(2.0)), image(1.5));
    }
}
