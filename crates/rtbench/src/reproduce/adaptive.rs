//! The adaptive grid's settings of 1999: ratio f, largest surface m, orphans in a grid or not.

use accel_core::counters::NoCounters;
use accel_core::params::Params;
use accel_core::primitives::MixedSet;
use accel_core::sink::{ClosestHit, HistoricalShadow};
use accel_core::structures::adaptive_grid::AdaptiveGrid;
use accel_core::structures::{PrimsRef, Structure};
use accel_core::tracer::Bound;
use renderer::RayKind;

use super::{PublishedScene, ReproduceError, Work, registered, uniform};

/// What is counted beyond the counters of every structure.
pub(super) struct Counted {
    work: Work,
    orphans: u64,
    hierarchy_nodes: u64,
    box_tests: u64,
}

/// Builds the adaptive grid with the published setting, like `f=1.5 m=0.1 o=-`, and counts.
pub(super) fn count(scene: &PublishedScene, params: &str) -> Result<Counted, ReproduceError> {
    let mut settings =
        vec![("boxes", "historical"), ("split", "2"), ("levels", "1"), ("exact-clusters", "16384")];
    for part in params.split_whitespace() {
        match part.split_once('=') {
            Some(("f", f)) => settings.push(("f", f)),
            Some(("m", m)) => settings.push(("m", m)),
            Some(("o", "+")) => settings.push(("orphan-grid", "on")),
            Some(("o", "-")) => settings.push(("orphan-grid", "off")),
            _ => return Err(ReproduceError::UnknownSetting(params.to_owned())),
        }
    }
    let params = registered("adaptive-grid")?.params(settings)?;
    match scene.geometry.prims() {
        PrimsRef::Mixed(prims) => count_over(scene, prims, &params),
        // scenes of 1999 are of mixed primitives
        _ => Err(ReproduceError::Missing("mixed primitives")),
    }
}

fn count_over(
    scene: &PublishedScene,
    prims: &MixedSet<f64>,
    params: &Params,
) -> Result<Counted, ReproduceError> {
    let grid = AdaptiveGrid::<f64>::build(prims, params)?;
    let (orphans, hierarchy_nodes) = (grid.orphans(), grid.hierarchy_nodes());
    let mut box_tests = 0;
    for kind in RayKind::ALL {
        for ray in scene.rays.rays(kind).iter().filter(|ray| ray.is_traceable()) {
            if kind.is_occlusion() {
                let mut sink = HistoricalShadow::<f64, _, NoCounters>::new(prims, ray);
                grid.walk_with(ray, &mut sink, || box_tests += 1);
            } else {
                let mut sink = ClosestHit::<f64, _, NoCounters>::new(prims, ray);
                grid.walk_with(ray, &mut sink, || box_tests += 1);
            }
        }
    }
    let work = scene.count(&Bound::new(prims, grid));
    Ok(Counted { work, orphans, hierarchy_nodes, box_tests })
}

/// The counters in the paper's symbols; those of rays per ray.
pub(super) fn counters(scene: &PublishedScene, counted: &Counted) -> Vec<(&'static str, f64)> {
    let mut all = uniform::counters(scene, &counted.work);
    all.extend([
        ("N_ORP", counted.orphans as f64),
        ("N_BB", counted.hierarchy_nodes as f64),
        ("N_BIT", counted.box_tests as f64 / scene.all_rays() as f64),
    ]);
    all
}
