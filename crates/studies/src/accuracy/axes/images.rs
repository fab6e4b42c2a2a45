//! Axes of images. Sampled effects: error against the number of samples. What a scene does not call
//! for is put on: a radius to its lights, a roughness to its mirrors, a velocity to every other
//! primitive, an aperture to its eye, each in parts of the scene's size. Effects left out or simulated.
//! Cones and beams against rays per pixel.

use glam::DVec3;
use measurement::plan::rows::Row;
use renderer::tracers::{Frame, Structures};
use renderer::{EffectPlan, Gating, Geometry, RenderSettings, render_plan};
use scene_loading::Scene;

use crate::accuracy::axis::*;
use crate::accuracy::sampled::{ImageCheck, RepeatedImage, Sampling, SamplingPlan};
use crate::images::rmse;
use crate::tracer_comparison::drawing_methods;

pub static SOFT_SHADOWS: Axis = Axis {
    summary: "shadow rays per hit and light",
    scenes: &["teapot", "balls:3", "pavilion"],
    ..sampled("soft-shadows", "render --samples shadow", |stage| SOFT.measure(stage))
};

pub static GLOSS: Axis = Axis {
    summary: "rays of the first rough mirror of a path",
    ..sampled("gloss", "render --samples glossy", |stage| ROUGH.measure(stage))
};

pub static MOTION: Axis = Axis {
    summary: "eye rays per pixel for the time the shutter is open",
    scenes: &["balls:3", "gears:2", "pavilion"],
    ..sampled("motion", "render --samples temporal", |stage| MOVING.measure(stage))
};

pub static FOCUS: Axis = Axis {
    summary: "eye rays per pixel for the area of the lens",
    paper: "Potmesil, Chakravarty 1981; Cook, Porter, Carpenter 1984",
    ..sampled("focus", "render --samples focal", |stage| BLURRED.measure(stage))
};

/// What axes of sampled images have in common.
const fn sampled(
    name: &'static str,
    setting: &'static str,
    measure: fn(&Stage<'_>) -> Result<SceneOutcome, StudyError>,
) -> Axis {
    Axis {
        name,
        summary: "",
        paper: "Cook, Porter, Carpenter 1984",
        metric: "root mean square difference of colours to the reference",
        reference: "mean of two images of many samples with other seeds; its error is half their \
                    distance",
        scenes: &["balls:3", "teapot", "pavilion"],
        setting,
        measure: Measure::Whole(measure),
    }
}

/// How an effect is put on a scene and sampled, and what is left of the scene without it.
struct EffectSetup {
    on: fn(&mut Scene),
    off: fn(&mut Scene),
    sampling: Sampling,
}

const SOFT: EffectSetup = EffectSetup {
    on: |scene| {
        let radius = 0.02 * diagonal(scene);
        scene.lights.iter_mut().for_each(|light| light.radius = radius.max(light.radius));
    },
    off: |scene| scene.lights.iter_mut().for_each(|light| light.radius = 0.0),
    sampling: Sampling::new("shadow", 1, |samples, n| samples.shadow = Some(n)),
};

const ROUGH: EffectSetup = EffectSetup {
    on: |scene| {
        let mirrors = scene.materials.iter().any(|m| m.specular > 0.0);
        for material in &mut scene.materials {
            if !mirrors {
                material.specular = 0.4;
            }
            if material.specular > 0.0 {
                material.roughness = material.roughness.max(0.2);
            }
        }
    },
    off: |scene| scene.materials.iter_mut().for_each(|material| material.roughness = 0.0),
    sampling: Sampling::new("glossy", 2, |samples, n| samples.glossy = Some(n)),
};

const MOVING: EffectSetup = EffectSetup {
    on: |scene| {
        let velocity = DVec3::new(0.8, 0.6, 0.0) * (0.02 * diagonal(scene));
        let every_other = |id: usize| if id.is_multiple_of(2) { velocity } else { DVec3::ZERO };
        scene.velocities = (0..scene.primitives.len()).map(every_other).collect();
        scene.camera.shutter = 1.0;
    },
    off: |scene| {
        scene.velocities.clear();
        scene.camera.shutter = 0.0;
    },
    sampling: Sampling::new("temporal", 1, |samples, n| samples.temporal = Some(n)),
};

const BLURRED: EffectSetup = EffectSetup {
    on: |scene| scene.camera.aperture = 0.01 * diagonal(scene),
    off: |scene| scene.camera.aperture = 0.0,
    sampling: Sampling::new("focal", 1, |samples, n| samples.focal = Some(n)),
};

impl EffectSetup {
    fn measure(&self, stage: &Stage<'_>) -> Result<SceneOutcome, StudyError> {
        let mut scene = stage.scene().clone();
        (self.on)(&mut scene);
        if scene.lights.is_empty() {
            return Err(stage.unfit("it has no lights"));
        }
        let geometry = Geometry::<f32>::of(&scene)?;
        let tracer = stage.over(TRACER, &geometry)?.tracer;
        // as it would be without the effect: gloss without its roughness, not without its mirrors
        let mut without = scene.clone();
        (self.off)(&mut without);
        let still = Geometry::<f32>::of(&without)?;
        let of_still = stage.over(TRACER, &still)?.tracer;
        let without = Some((&without, &*of_still));
        let ImageCheck { variants, said, .. } =
            self.sampling.judged(stage, (&scene, &*tracer), without)?;
        Ok(timed(stage, said, variants))
    }
}

pub static GATING: Axis = Axis {
    name: "effect-gating",
    summary: "effects that the scene does not use: left out, those of the eye simulated, all simulated",
    paper: "none",
    metric: "root mean square difference of colours to the image without them",
    reference: "the image without them",
    scenes: &["balls:3", "teapot", "pavilion"],
    setting: "renderer::EffectPlan::gated",
    measure: Measure::Whole(gatings),
};

const VARIANTS: [(&str, Gating); 3] = [
    ("left out", Gating::AsCalledFor),
    ("motion simulated", Gating::Eye),
    ("all simulated", Gating::All),
];

/// Pixels of the image, an axis, in a full run and in a quick one.
const SIZE: [u32; 2] = [96, 24];

fn gatings(stage: &Stage<'_>) -> Result<SceneOutcome, StudyError> {
    let built = stage.built(TRACER)?;
    let size = SIZE[usize::from(stage.limits.quick)];
    let settings = RenderSettings {
        resolution: [size; 2],
        seed: stage.limits.seed,
        ..RenderSettings::default()
    };
    let plan = EffectPlan::of(stage.scene(), &settings);
    let image = |plan: &EffectPlan| render_plan(stage.scene(), &*built.tracer, plan).image;
    let reference = image(&plan);
    let variants = VARIANTS.map(|(name, gating)| {
        let plan = plan.clone().gated(gating);
        let error = ErrorOf::Rmse { rmse: rmse(&image(&plan), &reference) };
        let setting = format!("EffectPlan::gated(Gating::{gating:?})");
        let work = RepeatedImage::rendered(stage.scene(), &*built.tracer, plan);
        Variant::new(name, setting, error, work).as_reference(gating == Gating::AsCalledFor)
    });
    let timed_image = format!("the image of {size} x {size} pixels, one thread");
    let said =
        SceneOutcome { pixels: size * size, ..SceneOutcome::new(timed_image, "the same image") };
    Ok(timed(stage, said, variants))
}

/// Structure that gives cones and beams their candidates.
const THROUGH: &str = "uniform-grid";
const DEPTH: u32 = 3;

/// `rtbench compare-tracers` asks the same of one scene at more sizes and with more samples.
pub static CONE_AND_BEAM: Axis = Axis {
    summary: "an image by cones or beams instead of rays, and rays per pixel",
    paper: "Amanatides 1984; Heckbert, Hanrahan 1984; Whitted 1980",
    scenes: &["tetra:4", "balls:3", "pavilion"],
    ..sampled("cone-and-beam", "compare-tracers; render --samples supersamples", cones_and_beams)
};

fn cones_and_beams(stage: &Stage<'_>) -> Result<SceneOutcome, StudyError> {
    let scene = stage.scene();
    let tracer = stage.built(TRACER)?.tracer;
    let double = Geometry::<f64>::of(scene)?;
    let rays = stage.over(TRACER, &double)?.tracer;
    let frusta = Row::parse(accel_core::structures::frustum_queries::REGISTRY, THROUGH)?;
    let queries = frusta.entry.build(double.prims(), &frusta.params);
    let queries = queries.map_err(|e| stage.refused(e))?;
    let sampling =
        Sampling::new("supersamples", DEPTH, |samples, n| samples.supersamples = Some(n));
    let ImageCheck { mut variants, mut said, reference } =
        sampling.judged(stage, (scene, &*tracer), None)?;
    let frame =
        Frame { resolution: [SamplingPlan::new(stage.limits.quick).size; 2], max_depth: DEPTH };
    for way in drawing_methods(|_| true) {
        let over = Structures { rays: &*rays, frusta: &*queries };
        let draw = move || (way.draw)(scene, frame, over);
        let image = match draw() {
            Ok(drawn) => drawn.image,
            Err(refusal) => {
                said.judged.push_str(&format!("; no {}: {}", way.label(), refusal.what));
                continue;
            }
        };
        let error = ErrorOf::Rmse { rmse: rmse(&image, &reference.image) };
        let setting = format!("compare-tracers --tracers {}", way.info.name);
        // what is refused was found before
        let work = RepeatedImage::new(move || draw().ok().map(|drawn| drawn.image));
        variants.push(Variant::new(way.label(), setting, error, work));
    }
    Ok(timed(stage, said, variants))
}
