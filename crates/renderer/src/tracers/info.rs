//! What is known of a tracer, and what it refuses.

use scene_loading::Scene;

/// What is known of a tracer.
#[derive(Debug)]
pub struct TracerInfo {
    pub name: &'static str,
    pub summary: &'static str,
    /// Where it comes from.
    pub paper: &'static str,
    /// What it takes for granted, where it approximates.
    pub assumptions: &'static str,
    /// What it does differently from the paper.
    pub deviations: &'static str,
    /// What in a scene it refuses, with a [`Refusal`].
    pub refuses: &'static str,
}

/// A scene that a tracer cannot trace rightly, and so does not.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{tracer} tracing cannot do scene {scene}: it has {what}")]
pub struct Refusal {
    /// Name of the tracer.
    pub tracer: &'static str,
    /// Name of the scene.
    pub scene: String,
    /// What the scene has: `91 spheres`.
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
