//! The recursive grid's four settings of 1999: RMD, the depth of the deepest grids, and RHT, `+`
//! for the heterogeneous resolution and `-` for the cube root.

use accel_core::tracer::{ShadowRule, Tracer};
use renderer::Geometry;

use super::{PublishedScene, ReproduceError, grid_counters, registered};

/// Builds the grid that `params` names, as `RMD=3 RHT=+`.
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

/// The counters of the setting that `params` names.
pub(super) fn counters(
    scene: &PublishedScene,
    params: &str,
) -> Result<Vec<(&'static str, f64)>, ReproduceError> {
    let tracer = build(&scene.geometry, params)?;
    let work = scene.count(tracer.as_ref(), ShadowRule::HistoricalInCell);
    Ok(grid_counters(scene, &work))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reproduce::published::{SCENES, figures, table};
    use scene_loading::procedural::generate_as_printed;

    #[test]
    #[ignore]
    fn shapes() {
        let figures = figures().unwrap();
        for scene in SCENES {
            let geometry = Geometry::<f64>::of(&generate_as_printed(scene).unwrap()).unwrap();
            for (params, published) in table(&figures, "recursive", scene) {
                let shape = build(&geometry, params).unwrap().shape();
                let ours = [shape.inner_cells, shape.cells, shape.empty_cells, shape.references];
                print!("{scene:8} {params}");
                for (name, ours) in ["N_IN", "N_V", "N_EV", "N_OIV"].iter().zip(ours) {
                    let p: u64 = published[name].parse().unwrap();
                    if p == ours {
                        print!("   exact")
                    } else {
                        print!("   {name} {p} {ours} {:.4}", ours as f64 / p as f64)
                    }
                }
                println!();
            }
        }
    }
}
