//! The uniform grid's three settings of 1999 (published resolutions, historical boxes, reversed
//! lists) and the recursive grid's four: RMD, the depth of the deepest grids, and RHT, `+` for the
//! heterogeneous resolution and `-` for the cube root.

use accel_core::query::tracer::{ShadowRule, Tracer};
use renderer::Geometry;

use super::setting::{
    Counted, PublishedScene, ReproduceError, SceneWork, Setting, grid_counters, registered,
};

/// Builds the uniform grid at the published resolution and counts.
pub(super) fn count_uniform(
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

/// The counters of a setting of the uniform grid.
pub(super) fn uniform(scene: &PublishedScene, setting: &Setting) -> Counted {
    let work = count_uniform(scene, setting.figures.get("resolution").copied())?;
    Ok(grid_counters(scene, &work))
}

/// Builds the recursive grid that `params` names, as `RMD=3 RHT=+`.
fn build<'g>(
    geometry: &'g Geometry<f64>,
    params: &str,
) -> Result<Box<dyn Tracer<f64> + 'g>, ReproduceError> {
    let of = |name| params.split_whitespace().find_map(|word| word.strip_prefix(name));
    let rule = if of("RHT=") == Some("+") { "heterogeneous" } else { "cube-root" };
    let settings = [
        ("max-depth", of("RMD=").unwrap_or("2")),
        ("resolution", rule),
        ("top-density", "1"),
        ("density", "1"),
        ("threshold", "8"),
        ("max-growth", "1e9"),
        ("boxes", "historical"),
    ];
    let entry = registered("recursive-grid")?;
    Ok(entry.build(geometry.prims(), &entry.params(settings)?)?)
}

/// The counters of a setting of the recursive grid.
pub(super) fn recursive(scene: &PublishedScene, setting: &Setting) -> Counted {
    let tracer = build(&scene.geometry, setting.params)?;
    let work = scene.count(tracer.as_ref(), ShadowRule::HistoricalInCell);
    Ok(grid_counters(scene, &work))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reproduce::published::{SCENES, figures, geometry, table};
    use crate::reproduce::setting::cell_counters;
    use crate::reproduce::verdict::{Verdict, judge};

    /// N_IN, N_V, N_EV and N_OIV in all four settings.
    #[test]
    fn shapes_are_as_published() {
        let figures = figures().unwrap();
        let (mut exact, mut within, mut known) = (0, 0, 0);
        for scene in SCENES {
            let geometry = geometry(scene);
            let settings = table(&figures, "recursive", scene);
            assert_eq!(settings.len(), 4, "{scene}");
            for (params, published) in settings {
                let stats = build(&geometry, params).unwrap().stats();
                for (counter, ours) in cell_counters(&stats) {
                    let text = published[counter];
                    let ours = ours as f64;
                    let ratio = ours / text.parse::<f64>().unwrap();
                    let what = format!("{scene} {params} {counter}: published {text}, ours {ours}");
                    match (scene, judge("recursive", params, scene, counter, text, ours)) {
                        (_, Verdict::Exact) => exact += 1,
                        ("mount", Verdict::Within) => within += 1,
                        ("rings" | "tree", Verdict::KnownReason(_))
                            if (ratio - 1.0).abs() < 0.04 =>
                        {
                            known += 1;
                        }
                        ("rings" | "tree", Verdict::Within) if ours != 0.0 => within += 1,
                        (_, verdict) => panic!("{what}: {verdict}"),
                    }
                }
            }
        }
        assert!(exact >= 80 && exact + within + known == 128, "{exact} {within} {known}");
    }
}
