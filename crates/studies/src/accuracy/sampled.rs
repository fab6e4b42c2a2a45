//! Images with samples: their errors, and the reference they are compared with.
//!
//! The reference is the mean of two images of many samples with different seeds; its own error is
//! half the distance between the two. Errors that are not ten times that are indistinguishable from
//! it.

use accel_core::query::tracer::Tracer;
use renderer::{EffectPlan, Image, RenderSettings, render_plan};
use scene_loading::{SampleWishes, Scene};

use crate::accuracy::audit;
use crate::accuracy::error_of::ErrorOf;
use crate::accuracy::record::SceneOutcome;
use crate::accuracy::stage::Stage;
use crate::accuracy::stage::Work;
use crate::accuracy::timing::{AxisReport, Variant, timed};
use crate::effect_plan::plan_of;
use crate::error::StudyError;
use crate::image_error::{ConvergedImage, rmse};
use measurement::system::machine;
use measurement::system::pools::pool;

/// Images of a variant with seeds of their own, over which errors are averaged.
const SEEDS: u64 = 8;

/// How an experiment samples.
#[derive(Debug, Clone, Copy)]
pub struct SamplingPlan {
    /// Pixels of the image, an axis.
    pub size: u32,
    /// Samples of the variants.
    pub samples: &'static [u32],
    /// Samples of each image of the reference.
    pub reference: u32,
}

impl SamplingPlan {
    /// Defaults of a full or a quick run.
    pub fn new(quick: bool) -> Self {
        if quick {
            Self { size: 12, samples: &[1, 4, 16], reference: 512 }
        } else {
            Self { size: 24, samples: &[1, 4, 16, 64, 256], reference: 8192 }
        }
    }
}

/// A sampled effect of a scene, and who traces it.
pub struct SampledEffect<'a> {
    /// The scene, the effect put on.
    pub scene: &'a Scene,
    pub tracer: &'a dyn Tracer<f32>,
    /// Longest chain of rays.
    pub max_depth: u32,
    /// Sets the number of samples.
    pub wish: fn(&mut SampleWishes, u32),
    /// How to have a number of samples without this command.
    pub option: &'static str,
    /// The scene without the effect, and who traces it; none where there is no such scene.
    pub without: Option<(&'a Scene, &'a dyn Tracer<f32>)>,
}

impl SampledEffect<'_> {
    fn plan(&self, size: u32, samples: u32, seed: u64) -> Result<EffectPlan, StudyError> {
        let mut wishes = SampleWishes::ONE_OF_EACH;
        (self.wish)(&mut wishes, samples);
        let settings = RenderSettings {
            resolution: [size; 2],
            max_depth: self.max_depth,
            samples: wishes,
            seed,
        };
        Ok(plan_of(self.scene, &settings)?)
    }

    fn image(&self, size: u32, samples: u32, seed: u64) -> Result<Image, StudyError> {
        Ok(render_plan(self.scene, self.tracer, &self.plan(size, samples, seed)?).image)
    }

    /// The image of a scene without the effect.
    fn left_out<'s>(
        &self,
        scene: &'s Scene,
        tracer: &'s dyn Tracer<f32>,
        size: u32,
        seed: u64,
    ) -> Result<Rendering<'s>, StudyError> {
        let settings = RenderSettings {
            resolution: [size; 2],
            max_depth: self.max_depth,
            samples: SampleWishes::ONE_OF_EACH,
            seed,
        };
        Ok(Rendering { scene, tracer, plan: plan_of(scene, &settings)?, image: None })
    }

    /// All numbers of samples, judged and timed.
    ///
    /// # Errors
    /// [`StudyError`] for more samples than fit, or threads that cannot be started.
    pub fn measured(&self, stage: &Stage<'_>) -> Result<SceneOutcome, StudyError> {
        let ImageCheck { variants, said, .. } = self.judged(stage)?;
        Ok(timed(stage, said, variants))
    }

    /// All numbers of samples, judged, to be timed.
    ///
    /// # Errors
    /// [`StudyError`] for more samples than fit, or threads that cannot be started.
    pub fn judged<'s>(&'s self, stage: &Stage<'_>) -> Result<ImageCheck<'s>, StudyError> {
        let mut plan = SamplingPlan::new(stage.quick);
        let seeds = if stage.only_times { 1 } else { SEEDS };
        if stage.only_times {
            plan.reference = 1;
        }
        // what is not timed may use the whole machine
        let helper = pool(machine::threads())?;
        let image = |n, seed| helper.install(|| self.image(plan.size, n, seed));
        // seeds that no variant has
        let far = |i: u64| stage.seed.wrapping_mul(1009).wrapping_add(100_000 + i);
        let [a, b] = [image(plan.reference, far(0))?, image(plan.reference, far(1))?];
        let reference = ConvergedImage::of(&a, &b);
        let mut faults = Vec::new();
        let mut variants = Vec::new();
        if let Some((scene, tracer)) = self.without {
            let mut left_out = self.left_out(scene, tracer, plan.size, stage.seed)?;
            let image = helper.install(|| render_plan(scene, tracer, &left_out.plan).image);
            left_out.image = None;
            variants.push(Variant {
                name: "left out".into(),
                setting: "render, of the scene without what calls for it".into(),
                known_defect: None,
                is_without: true,
                is_reference: false,
                error: ErrorOf::Rmse { rmse: rmse(&image, &reference.image) },
                also: vec![("samples", 0.0)],
                work: Box::new(left_out),
            });
        }
        for &n in plan.samples {
            let images = (0..seeds).map(|i| stage.seed.wrapping_mul(31).wrapping_add(i));
            let images =
                images.map(|seed| image(n, seed)).collect::<Result<Vec<Image>, StudyError>>()?;
            let squares: f64 = images.iter().map(|i| rmse(i, &reference.image).powi(2)).sum();
            let error = (squares / seeds as f64).sqrt();
            if Some(&n) == plan.samples.last() && !stage.only_times {
                faults.extend(audit::bad_reference(error, scatter(&images), reference.own_error));
            }
            variants.push(Variant {
                name: format!("{n} samples"),
                setting: format!("render {}={n}", self.option),
                known_defect: None,
                is_without: false,
                is_reference: false,
                error: ErrorOf::Rmse { rmse: error },
                also: vec![("samples", f64::from(n))],
                work: Box::new(Rendering {
                    scene: self.scene,
                    tracer: self.tracer,
                    plan: self.plan(plan.size, n, stage.seed)?,
                    image: None,
                }),
            });
        }
        let said = AxisReport {
            timed: format!("the image of {0} x {0} pixels, one thread", plan.size),
            judged: format!(
                "the mean square over {SEEDS} seeds; reference: 2 x {} samples",
                plan.reference
            ),
            reference_error: reference.own_error,
            faults,
            pixels: plan.size * plan.size,
            ..AxisReport::default()
        };
        Ok(ImageCheck { variants, said, reference })
    }
}

/// Errors of sampled images, computed before they are timed.
pub struct ImageCheck<'a> {
    pub variants: Vec<Variant<'a>>,
    /// Report on the images.
    pub said: AxisReport,
    /// Reference that they were compared with.
    pub reference: ConvergedImage,
}

/// An image that is made again and again, in the current rayon pool.
pub struct Rendering<'a> {
    pub scene: &'a Scene,
    pub tracer: &'a dyn Tracer<f32>,
    pub plan: EffectPlan,
    pub image: Option<Image>,
}

impl Work for Rendering<'_> {
    fn prepare(&mut self) {
        self.image = None;
    }

    fn run(&mut self) {
        self.image = Some(render_plan(self.scene, self.tracer, &self.plan).image);
    }

    fn fingerprint(&self) -> u64 {
        fingerprint(self.image.as_ref())
    }
}

/// A number that changes with any bit of an image.
pub fn fingerprint(image: Option<&Image>) -> u64 {
    use std::hash::{DefaultHasher, Hash, Hasher};
    let mut hasher = DefaultHasher::new();
    let pixels = image.into_iter().flat_map(|image| image.pixels.as_flattened());
    pixels.for_each(|x| x.to_bits().hash(&mut hasher));
    hasher.finish()
}

/// The error of one of several equal images by their distances from each other alone.
fn scatter(images: &[Image]) -> f64 {
    let (mut squares, mut pairs) = (0.0, 0.0);
    for (i, a) in images.iter().enumerate() {
        for b in images.iter().skip(i + 1) {
            squares += rmse(a, b).powi(2);
            pairs += 1.0;
        }
    }
    (squares / f64::max(pairs, 1.0) / 2.0).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_of_images_from_each_other() {
        let image = |x: f64| Image { width: 1, height: 2, pixels: vec![[x; 3]; 2] };
        assert_eq!(scatter(&[image(1.0), image(1.0)]), 0.0);
        assert!((scatter(&[image(1.0), image(2.0)]) - 0.5_f64.sqrt()).abs() < 1e-12);
    }
}
