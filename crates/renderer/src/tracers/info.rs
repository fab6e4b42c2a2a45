//! Descriptions of tracers, and of scenes that they do not support.

use scene_loading::Scene;

/// Description of a tracer.
#[derive(Debug)]
pub struct TracerInfo {
    pub name: &'static str,
    pub summary: &'static str,
    /// Where it comes from.
    pub paper: &'static str,
    /// Assumptions of its approximations.
    pub assumptions: &'static str,
    /// Deviations from the paper.
    pub deviations: &'static str,
    /// Unsupported parts of scenes, answered with a [`Refusal`].
    pub refuses: &'static str,
}

/// A scene that a tracer cannot trace rightly, and so does not.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{tracer} tracing does not support scene {scene}: it has {what}")]
pub struct Refusal {
    /// Name of the tracer.
    pub tracer: &'static str,
    /// Name of the scene.
    pub scene: String,
    /// The unsupported part: `91 spheres`.
    pub what: String,
}

impl Refusal {
    /// Refuses the scene if it has any of `what`.
    ///
    /// # Errors
    /// [`Refusal`] unless `count` is 0.
    pub fn of(
        tracer: &'static TracerInfo,
        scene: &Scene,
        count: usize,
        what: &str,
    ) -> Result<(), Self> {
        if count == 0 {
            return Ok(());
        }
        let what = format!("{count} {what}");
        Err(Self { tracer: tracer.name, scene: scene.name.clone(), what })
    }
}
