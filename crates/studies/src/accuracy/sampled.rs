//! Images with samples: their errors, and the reference they are compared with.
//!
//! The reference is the mean of two images of many samples with different seeds; its own error is
//! half the distance between the two. Errors that are not ten times that are indistinguishable from
//! it.

use std::hash::{DefaultHasher, Hash, Hasher};

use accel_core::query::tracer::Tracer;
use renderer::{EffectPlan, Image, RenderSettings, render_plan};
use scene_loading::{SampleWishes, Scene};

use crate::accuracy::record::{ErrorOf, SceneOutcome};
use crate::accuracy::stage::{Stage, Work};
use crate::accuracy::timing::Variant;
use crate::error::StudyError;
use crate::images::{ConvergedImage, plan_of, rmse};
use measurement::system::machine;
use measurement::system::pools::pool;

/// Images of a variant with seeds of their own, over which errors are averaged.
const SEEDS: u64 = 8;

#[derive(Debug, Clone, Copy)]
pub struct SamplingPlan {
    /// Pixels of the image, an axis.
    pub size: u32,
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

/// How samples of an effect are asked for.
pub struct Sampling {
    /// Of `render --samples`.
    option: &'static str,
    max_depth: u32,
    wish: fn(&mut SampleWishes, u32),
}

/// A scene and who traces it.
pub type TracedScene<'a> = (&'a Scene, &'a dyn Tracer<f32>);

impl Sampling {
    pub const fn new(
        option: &'static str,
        max_depth: u32,
        wish: fn(&mut SampleWishes, u32),
    ) -> Self {
        Self { option, max_depth, wish }
    }

    /// An image of a scene with so many samples, or one of each.
    fn plan(
        &self,
        scene: &Scene,
        size: u32,
        samples: Option<u32>,
        seed: u64,
    ) -> Result<EffectPlan, StudyError> {
        let mut wishes = SampleWishes::ONE_OF_EACH;
        if let Some(n) = samples {
            (self.wish)(&mut wishes, n);
        }
        let (resolution, max_depth) = ([size; 2], self.max_depth);
        Ok(plan_of(scene, &RenderSettings { resolution, max_depth, samples: wishes, seed })?)
    }

    /// All numbers of samples, judged, to be timed; beside them the scene without the effect, where
    /// there is such a scene.
    pub fn judged<'s>(
        &self,
        stage: &Stage<'_>,
        (scene, tracer): TracedScene<'s>,
        without: Option<TracedScene<'s>>,
    ) -> Result<ImageCheck<'s>, StudyError> {
        let mut plan = SamplingPlan::new(stage.limits.quick);
        let seeds = if stage.limits.only_times { 1 } else { SEEDS };
        if stage.limits.only_times {
            plan.reference = 1;
        }
        // what is not timed may use the whole machine
        let helper = pool(machine::threads())?;
        let image = |n, seed| -> Result<Image, StudyError> {
            let plan = self.plan(scene, plan.size, Some(n), seed)?;
            Ok(helper.install(|| render_plan(scene, tracer, &plan).image))
        };
        // seeds that no variant has
        let far = |i: u64| stage.limits.seed.wrapping_mul(1009).wrapping_add(100_000 + i);
        let [a, b] = [image(plan.reference, far(0))?, image(plan.reference, far(1))?];
        let reference = ConvergedImage::of(&a, &b);
        let mut faults = Vec::new();
        let mut variants = Vec::new();
        if let Some((scene, tracer)) = without {
            let plain = self.plan(scene, plan.size, None, stage.limits.seed)?;
            let image = helper.install(|| render_plan(scene, tracer, &plain).image);
            let error = ErrorOf::Rmse { rmse: rmse(&image, &reference.image) };
            let setting = "render, of the scene without what calls for it";
            let work = RepeatedImage::rendered(scene, tracer, plain);
            let mut variant = Variant::new("left out", setting, error, work);
            variant.record.is_without = true;
            variants.push(variant.also([("samples", 0.0)]));
        }
        for &n in plan.samples {
            let of_seed = |i| image(n, stage.limits.seed.wrapping_mul(31).wrapping_add(i));
            let images = (0..seeds).map(of_seed).collect::<Result<Vec<Image>, StudyError>>()?;
            let squares: f64 = images.iter().map(|i| rmse(i, &reference.image).powi(2)).sum();
            let error = (squares / seeds as f64).sqrt();
            if Some(&n) == plan.samples.last() && !stage.limits.only_times {
                faults.extend(bad_reference(error, scatter(&images), reference.own_error));
            }
            let error = ErrorOf::Rmse { rmse: error };
            let plan = self.plan(scene, plan.size, Some(n), stage.limits.seed)?;
            let work = RepeatedImage::rendered(scene, tracer, plan);
            let setting = format!("render --samples {}={n}", self.option);
            let variant = Variant::new(format!("{n} samples"), setting, error, work);
            variants.push(variant.also([("samples", f64::from(n))]));
        }
        let said = SceneOutcome {
            reference_error: reference.own_error,
            faults,
            pixels: plan.size * plan.size,
            ..SceneOutcome::new(
                format!("the image of {0} x {0} pixels, one thread", plan.size),
                format!(
                    "the mean square over {SEEDS} seeds; reference: 2 x {} samples",
                    plan.reference
                ),
            )
        };
        Ok(ImageCheck { variants, said, reference })
    }
}

/// Errors of sampled images, computed before they are timed.
pub struct ImageCheck<'a> {
    pub variants: Vec<Variant<'a>>,
    pub said: SceneOutcome,
    pub reference: ConvergedImage,
}

/// An image that is made again and again, in the current rayon pool.
pub struct RepeatedImage<'a> {
    make: Box<dyn Fn() -> Option<Image> + 'a>,
    image: Option<Image>,
}

impl<'a> RepeatedImage<'a> {
    pub fn new(make: impl Fn() -> Option<Image> + 'a) -> Self {
        Self { make: Box::new(make), image: None }
    }

    /// Of a scene with effects.
    pub fn rendered(scene: &'a Scene, tracer: &'a dyn Tracer<f32>, plan: EffectPlan) -> Self {
        Self::new(move || Some(render_plan(scene, tracer, &plan).image))
    }
}

impl Work for RepeatedImage<'_> {
    fn prepare(&mut self) {
        self.image = None;
    }

    fn run(&mut self) {
        self.image = (self.make)();
    }

    /// A number that changes with any bit of the image.
    fn fingerprint(&self) -> u64 {
        let mut hasher = DefaultHasher::new();
        let pixels = self.image.iter().flat_map(|image| image.pixels.as_flattened());
        pixels.for_each(|x| x.to_bits().hash(&mut hasher));
        hasher.finish()
    }
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

/// Factor by which a variant's distance from the reference may exceed its scatter plus the
/// reference's own error. Both are estimates, which few pixels may decide.
const TOLERATED: f64 = 3.0;

/// A sampled reference that is worse than it says: `error` is that of the finest variant to it,
/// `scatter` the variant's own by its seeds, `own` the reference's.
fn bad_reference(error: f64, scatter: f64, own: f64) -> Option<String> {
    let explained = scatter.hypot(own);
    (error > TOLERATED * explained).then(|| {
        format!(
            "the reference is less accurate than stated: the finest variant differs by \
             {error:.2e}; scatter and the stated error explain {explained:.2e}"
        )
    })
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

    #[test]
    fn a_reference_less_accurate_than_stated_is_caught() {
        assert_eq!(bad_reference(0.011, 0.01, 0.001), None);
        assert!(bad_reference(0.04, 0.01, 0.001).is_some());
        // planted: an honest reference that states a tenth of its error
        assert!(bad_reference(0.03, 0.003, 0.003).is_some());
    }
}
