//! The uniform grid's three settings of 1999: published resolutions, historical boxes, reversed
//! lists.

use accel_core::tracer::ShadowRule;

use super::{PublishedScene, ReproduceError, Work, registered};

/// Builds the grid at the published resolution and counts.
pub(super) fn count(
    scene: &PublishedScene,
    resolution: Option<&str>,
) -> Result<Work, ReproduceError> {
    let entry = registered("uniform-grid")?;
    let settings = [
        ("resolution", resolution.unwrap_or("heterogeneous")),
        ("boxes", "historical"),
        ("order", "reverse"),
    ];
    let tracer = entry.build(scene.geometry.prims(), &entry.params(settings)?)?;
    Ok(scene.count(tracer.as_ref(), ShadowRule::Historical))
}
