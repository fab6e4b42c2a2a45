//! HUG's five settings of 1999: HNG size classes, gap HCN, historical boxes.

use accel_core::query::tracer::ShadowRule;

use super::setting::{Counted, PublishedScene, ReproduceError, Setting, grid_counters, registered};

/// The settings of `hug` for a published one like `HNG=2 HCN=0`.
fn settings(params: &str) -> Result<Vec<(&str, &str)>, ReproduceError> {
    let mut settings = vec![("boxes", "historical")];
    for part in params.split_whitespace() {
        match part.split_once('=') {
            Some(("HNG", classes)) => settings.push(("size-classes", classes)),
            Some(("HCN", gap)) => settings.push(("gap", gap)),
            _ => return Err(ReproduceError::UnknownSetting(params.to_owned())),
        }
    }
    Ok(settings)
}

/// Builds HUG with the published setting and counts.
pub(super) fn counters(
    scene: &PublishedScene,
    setting: &Setting,
) -> Result<Counted, ReproduceError> {
    let entry = registered("hug")?;
    let params = entry.params(settings(setting.params)?)?;
    let tracer = entry.build(scene.geometry.prims(), &params)?;
    Ok(grid_counters(scene, &scene.count(tracer.as_ref(), ShadowRule::Historical)))
}

#[cfg(test)]
mod tests {
    use super::super::published::{figures, table};
    use super::*;
    use renderer::Geometry;
    use scene_loading::procedural::generate_as_printed;

    #[test]
    fn two_classes_have_the_published_cells_in_lattice_mount_and_tetra() {
        let figures = figures().unwrap();
        for name in ["lattice", "mount", "tetra"] {
            let geometry = Geometry::<f64>::of(&generate_as_printed(name).unwrap()).unwrap();
            let published = table(&figures, "hug", name);
            let (params, counters) = published.iter().find(|p| p.0 == "HNG=2 HCN=0").unwrap();
            let entry = registered("hug").unwrap();
            let params = entry.params(settings(params).unwrap()).unwrap();
            let shape = entry.build(geometry.prims(), &params).unwrap().shape();
            assert_eq!(shape.inner_cells.to_string(), counters["N_IN"], "{name}");
            assert_eq!(shape.cells.to_string(), counters["N_V"], "{name}");
        }
        assert!(settings("HNG=2 X=3").is_err());
    }
}
