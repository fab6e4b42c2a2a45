//! Effects that a scene does not call for: left out, or simulated with an extent of zero.

use renderer::{EffectPlan, Gating, RenderSettings, render_plan};

use crate::accuracy::axis::{Axis, Measure};
use crate::accuracy::error_of::ErrorOf;
use crate::accuracy::record::SceneOutcome;
use crate::accuracy::sampled::Rendering;
use crate::accuracy::stage::{Stage, TRACER};
use crate::accuracy::timing::{AxisReport, Variant, timed};
use crate::error::StudyError;
use crate::image_error::rmse;

pub static AXIS: Axis = Axis {
    name: "effect-gating",
    summary: "effects that nothing calls for: left out, those of the eye in, all in",
    paper: "none",
    metric: "root mean square difference of colours to the image without them",
    reference: "the image without them",
    scenes: &["balls:3", "teapot", "pavilion"],
    setting: "renderer::EffectPlan::gated",
    measure: Measure::Whole(measure),
};

const VARIANTS: [(&str, Gating); 3] = [
    ("left out", Gating::AsCalledFor),
    ("motion simulated", Gating::Eye),
    ("all simulated", Gating::All),
];

/// Pixels of the image, an axis, in a full run and in a quick one.
const SIZE: [u32; 2] = [96, 24];

fn measure(stage: &Stage<'_>) -> Result<SceneOutcome, StudyError> {
    let built = stage.built(TRACER)?;
    let size = SIZE[usize::from(stage.quick)];
    let settings =
        RenderSettings { resolution: [size; 2], seed: stage.seed, ..RenderSettings::default() };
    let plan = EffectPlan::of(stage.scene(), &settings);
    let image = |plan: &EffectPlan| render_plan(stage.scene(), &*built.tracer, plan).image;
    let reference = image(&plan);
    let variants = VARIANTS.map(|(name, gating)| {
        let plan = plan.clone().gated(gating);
        Variant {
            name: name.into(),
            setting: format!("EffectPlan::gated(Gating::{gating:?})"),
            known_defect: None,
            is_without: false,
            is_reference: gating == Gating::AsCalledFor,
            error: ErrorOf::Rmse { rmse: rmse(&image(&plan), &reference) },
            also: Vec::new(),
            work: Box::new(Rendering {
                scene: stage.scene(),
                tracer: &*built.tracer,
                plan,
                image: None,
            }),
        }
    });
    let said = AxisReport {
        timed: format!("the image of {size} x {size} pixels, one thread"),
        judged: "the same image".into(),
        pixels: size * size,
        ..AxisReport::default()
    };
    Ok(timed(stage, said, variants.into_iter().collect()))
}
