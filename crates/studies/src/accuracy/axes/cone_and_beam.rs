//! Bundles of rays against samples: an image by cones, by beams, and by so many rays per pixel.
//!
//! `rtbench compare-tracers` asks the same of one scene at more sizes and with more samples.

use renderer::Geometry;
use renderer::Image;
use renderer::tracers::{DrawnImage, Frame, Refusal, Structures};
use scene_loading::Scene;

use crate::accuracy::axis::{Axis, Measure};
use crate::accuracy::error_of::ErrorOf;
use crate::accuracy::record::SceneOutcome;
use crate::accuracy::sampled::{ImageCheck, SampledEffect, SamplingPlan, fingerprint};
use crate::accuracy::stage::Work;
use crate::accuracy::stage::{Stage, TRACER};
use crate::accuracy::timing::{Variant, timed};
use crate::error::StudyError;
use crate::image_error::rmse;
use crate::tracer_comparison::{DrawingMethod, drawing_methods};
use measurement::plan::rows::Row;

/// Structure that gives cones and beams their candidates.
const THROUGH: &str = "uniform-grid";
/// Longest chain of rays.
const DEPTH: u32 = 3;

pub static AXIS: Axis = Axis {
    name: "cone-and-beam",
    summary: "an image by cones or beams instead of rays, and rays per pixel",
    paper: "Amanatides 1984; Heckbert, Hanrahan 1984; Whitted 1980",
    metric: "root mean square difference of colours to the reference",
    reference: "mean of two images of many samples with other seeds; its error is half their \
                distance",
    scenes: &["tetra:4", "balls:3", "pavilion"],
    setting: "compare-tracers; render --supersamples",
    measure: Measure::Whole(measure),
};

fn measure(stage: &Stage<'_>) -> Result<SceneOutcome, StudyError> {
    let scene = stage.scene();
    let row = Row::parse(stage.registry, TRACER)?;
    let refused = |e| stage.refused(e);
    let prims = stage.prepared.geometry.prims();
    let tracer = row.entry.build(prims, &row.params).map_err(refused)?;
    let double = Geometry::<f64>::of(scene)?;
    let rays = row.entry.build(double.prims(), &row.params).map_err(refused)?;
    let frusta = Row::parse(accel_core::structures::frustum_queries::REGISTRY, THROUGH)?;
    let queries = frusta.entry.build(double.prims(), &frusta.params).map_err(refused)?;
    let sampled = SampledEffect {
        scene,
        tracer: &*tracer,
        max_depth: DEPTH,
        wish: |samples, n| samples.supersamples = Some(n),
        option: "--supersamples",
        without: None,
    };
    let ImageCheck { mut variants, mut said, reference } = sampled.judged(stage)?;
    let frame = Frame { resolution: [SamplingPlan::new(stage.quick).size; 2], max_depth: DEPTH };
    for way in drawing_methods(|_| true) {
        let mut drawing = Drawing {
            scene,
            frame,
            over: Structures { rays: &*rays, frusta: &*queries },
            way,
            image: None,
        };
        let image = match drawing.draw() {
            Ok(drawn) => drawn.image,
            Err(refusal) => {
                said.judged.push_str(&format!("; no {}: {}", way.label(), refusal.what));
                continue;
            }
        };
        drawing.image = None;
        variants.push(Variant {
            name: way.label(),
            setting: format!("compare-tracers --tracers {}", way.info.name),
            known_defect: None,
            is_without: false,
            is_reference: false,
            error: ErrorOf::Rmse { rmse: rmse(&image, &reference.image) },
            also: Vec::new(),
            work: Box::new(drawing),
        });
    }
    Ok(timed(stage, said, variants))
}

/// An image by cones or beams that is made again and again, in the current rayon pool.
struct Drawing<'a> {
    scene: &'a Scene,
    frame: Frame,
    over: Structures<'a>,
    way: &'static DrawingMethod,
    image: Option<Image>,
}

impl Drawing<'_> {
    fn draw(&self) -> Result<DrawnImage, Refusal> {
        (self.way.draw)(self.scene, self.frame, self.over)
    }
}

impl Work for Drawing<'_> {
    fn prepare(&mut self) {
        self.image = None;
    }

    fn run(&mut self) {
        // what is refused was found before
        self.image = self.draw().ok().map(|drawn| drawn.image);
    }

    fn fingerprint(&self) -> u64 {
        fingerprint(self.image.as_ref())
    }
}
