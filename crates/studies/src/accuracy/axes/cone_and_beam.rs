//! Bundles of rays against samples: an image by cones, by beams, and by so many rays per pixel.
//!
//! `rtbench compare-tracers` asks the same of one scene at more sizes and with more samples.

use measurement::plan::rows::Row;
use renderer::Geometry;
use renderer::tracers::{Frame, Structures};

use super::prelude::*;
use crate::accuracy::sampled::{ImageCheck, RepeatedImage, SampledEffect, SamplingPlan};
use crate::image_error::rmse;
use crate::tracer_comparison::drawing_methods;

/// Structure that gives cones and beams their candidates.
const THROUGH: &str = "uniform-grid";
const DEPTH: u32 = 3;

pub static AXIS: Axis = Axis {
    name: "cone-and-beam",
    summary: "an image by cones or beams instead of rays, and rays per pixel",
    paper: "Amanatides 1984; Heckbert, Hanrahan 1984; Whitted 1980",
    metric: "root mean square difference of colours to the reference",
    reference: "mean of two images of many samples with other seeds; its error is half their \
                distance",
    scenes: &["tetra:4", "balls:3", "pavilion"],
    setting: "compare-tracers; render --samples supersamples",
    measure: Measure::Whole(measure),
};

fn measure(stage: &Stage<'_>) -> Result<SceneOutcome, StudyError> {
    let scene = stage.scene();
    let tracer = stage.over(TRACER, &stage.prepared.geometry)?;
    let double = Geometry::<f64>::of(scene)?;
    let rays = stage.over(TRACER, &double)?;
    let frusta = Row::parse(accel_core::structures::frustum_queries::REGISTRY, THROUGH)?;
    let queries = frusta.entry.build(double.prims(), &frusta.params);
    let queries = queries.map_err(|e| stage.refused(e))?;
    let sampled = SampledEffect {
        scene,
        tracer: &*tracer,
        max_depth: DEPTH,
        wish: |samples, n| samples.supersamples = Some(n),
        option: "supersamples",
        without: None,
    };
    let ImageCheck { mut variants, mut said, reference } = sampled.judged(stage)?;
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
