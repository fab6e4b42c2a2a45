//! The uniform grid's three settings of 1999: published resolutions, historical boxes, reversed
//! lists.

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
    Ok(scene.count(tracer.as_ref()))
}

/// The counters in the paper's symbols; those of rays per ray.
pub(super) fn counters(scene: &PublishedScene, work: &Work) -> Vec<(&'static str, f64)> {
    let per_ray = |n: u64| n as f64 / scene.all_rays() as f64;
    vec![
        ("N_IN", work.shape.inner_cells as f64),
        ("N_V", work.shape.cells as f64),
        ("N_EV", work.shape.empty_cells as f64),
        ("N_OIV", work.shape.references as f64),
        ("N_IT", per_ray(work.counters.intersection_tests)),
        ("N_TS", per_ray(work.counters.traversal_steps)),
        ("N_ETS", per_ray(work.counters.elementary_steps)),
        ("N_EETS", per_ray(work.counters.empty_elementary_steps)),
    ]
}
