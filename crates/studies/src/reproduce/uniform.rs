//! The uniform grid's three settings of 1999: published resolutions, historical boxes, reversed
//! lists.

use accel_core::query::tracer::ShadowRule;

use super::setting::{
    PaperCounters, PublishedScene, ReproduceError, SceneWork, Setting, grid_counters, registered,
};

/// Builds the grid at the published resolution and counts.
pub(super) fn count(
    scene: &PublishedScene,
    resolution: Option<&str>,
) -> Result<SceneWork, ReproduceError> {
    let entry = registered("uniform-grid")?;
    let settings = [
        ("resolution", resolution.unwrap_or("heterogeneous")),
        ("boxes", "historical"),
        ("order", "reverse"),
    ];
    let tracer = entry.build(scene.geometry.prims(), &entry.params(settings)?)?;
    Ok(scene.count(tracer.as_ref(), ShadowRule::Historical))
}

/// The counters of one setting.
pub(super) fn counters(
    scene: &PublishedScene,
    setting: &Setting,
) -> Result<PaperCounters, ReproduceError> {
    let work = count(scene, setting.figures.get("resolution").copied())?;
    Ok(grid_counters(scene, &work))
}
