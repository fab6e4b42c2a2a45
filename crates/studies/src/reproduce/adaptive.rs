//! The adaptive grid's settings of 1999: ratio f, largest surface m, orphans in a grid or not.

use accel_core::historical::shadow_sink::HistoricalShadow;
use accel_core::params::Params;
use accel_core::params::config::Settings;
use accel_core::primitives::PrimSet;
use accel_core::primitives::PrimsRef;
use accel_core::query::counters::NoCounters;
use accel_core::query::sink::ClosestHit;
use accel_core::query::tracer::{Bound, ShadowRule};
use accel_core::structure::Structure;
use accel_core::structures::adaptive_grid::AdaptiveGrid;
use renderer::RayKind;

use super::setting::{Counted, PublishedScene, ReproduceError, Setting, grid_counters, registered};

/// The settings of `adaptive-grid` for a published one like `f=1.5 m=0.1 o=-`.
fn settings(params: &str) -> Result<Vec<(&str, &str)>, ReproduceError> {
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
    Ok(settings)
}

/// Builds the adaptive grid with the published setting and counts.
pub(super) fn counters(scene: &PublishedScene, setting: &Setting) -> Counted {
    let params = registered("adaptive-grid")?.params(settings(setting.params)?)?;
    match scene.geometry.prims() {
        PrimsRef::Mixed(prims) => count_over(scene, prims, &params),
        PrimsRef::Watertight(prims) => count_over(scene, prims, &params),
    }
}

fn count_over<P: PrimSet<f64>>(scene: &PublishedScene, prims: &P, params: &Params) -> Counted {
    let grid = AdaptiveGrid::<f64>::build(prims, &Settings::of(params))?;
    let (orphans, hierarchy_nodes) = (grid.orphans(), grid.hierarchy_nodes());
    let mut nodes_entered = 0;
    for kind in RayKind::ALL {
        for ray in scene.rays.rays(kind).iter().filter(|ray| ray.is_traceable()) {
            if kind.is_occlusion() {
                let mut sink = HistoricalShadow::<f64, _, NoCounters>::new(prims, ray);
                grid.traverse_with(ray, &mut sink, || nodes_entered += 1);
            } else {
                let mut sink = ClosestHit::<f64, _, NoCounters>::new(prims, ray);
                grid.traverse_with(ray, &mut sink, || nodes_entered += 1);
            }
        }
    }
    let work = scene.count(&Bound::<_, _, _, true>::new(prims, grid), ShadowRule::Historical);
    let mut all = grid_counters(scene, &work);
    all.extend([
        ("N_ORP", orphans as f64),
        ("N_BB", hierarchy_nodes as f64),
        ("N_BIT", nodes_entered as f64 / scene.all_rays() as f64),
    ]);
    Ok(all)
}

#[cfg(test)]
mod tests {
    use super::super::published::{figures, geometry, table};
    use super::super::setting::cell_counters;
    use super::*;

    #[test]
    fn four_scenes_have_about_the_published_cells() {
        let figures = figures().unwrap();
        for (name, tolerance) in [("balls", 0.12), ("tree", 0.12), ("mount", 0.25), ("tetra", 0.25)]
        {
            let geometry = geometry(name);
            let published = table(&figures, "adaptive", name);
            let (params, counters) = published.iter().find(|p| p.0 == "f=1.5 m=0.5 o=-").unwrap();
            let entry = registered("adaptive-grid").unwrap();
            let params = entry.params(settings(params).unwrap()).unwrap();
            let stats = entry.build(geometry.prims(), &params).unwrap().stats();
            for (counter, ours) in cell_counters(&stats) {
                let value: f64 = counters[counter].parse().unwrap();
                let ratio = ours as f64 / value;
                assert!((ratio - 1.0).abs() <= tolerance, "{name} {counter}: {ratio}");
            }
        }
        assert!(settings("f=1.5 o=?").is_err());
    }
}
