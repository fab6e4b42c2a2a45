//! Rays of an image with effects, within the memory limit.

use measurement::plan::error::PlanError;
use renderer::effects::plan::MOST_SAMPLES_PER_PIXEL;
use renderer::{EffectPlan, RenderSettings};
use scene_loading::Scene;

/// The effect plan, unless its samples would fill the memory.
pub fn plan_of(scene: &Scene, settings: &RenderSettings) -> Result<EffectPlan, PlanError> {
    let plan = EffectPlan::of(scene, settings);
    if plan.samples_per_pixel() > MOST_SAMPLES_PER_PIXEL {
        return Err(PlanError::Malformed {
            text: format!("{} eye x glossy x shadow samples per pixel", plan.samples_per_pixel()),
            expected: "at most 4194304 of them",
        });
    }
    Ok(plan)
}
