//! HUG's five settings of 1999: HNG size classes, gap HCN, historical boxes.

use std::cmp::Ordering;

use accel_core::query::tracer::{ShadowRule, Tracer};
use accel_core::structure::StructureStats;
use renderer::Geometry;

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
pub(super) fn counters(scene: &PublishedScene, setting: &Setting) -> Counted {
    let own = build(&scene.geometry, setting.params, 0)?;
    let cells = own.stats().cells;
    let sized = sized_as_published(&scene.geometry, setting, own.stats())?;
    let work = scene.count(sized.unwrap_or(own).as_ref(), ShadowRule::Historical);
    let mut counters = grid_counters(scene, &work);
    for (name, value) in &mut counters {
        if *name == "N_V" {
            *value = cells as f64;
        }
    }
    Ok(counters)
}

type HugTracer<'g> = Box<dyn Tracer<f64> + 'g>;

/// HUG with a root sized for so many primitives; 0 for as many as its class has.
fn build<'g>(
    geometry: &'g Geometry<f64>,
    params: &str,
    root_objects: usize,
) -> Result<HugTracer<'g>, ReproduceError> {
    let entry = registered("hug")?;
    let root_objects = root_objects.to_string();
    let mut settings = settings(params)?;
    settings.push(("root-objects", &root_objects));
    Ok(entry.build(geometry.prims(), &entry.params(settings)?)?)
}

/// If we and the paper have one grid over all primitives, but of different sizes: the grid with the
/// published number of cells. Its sizing rule is unknown; as for uniform grids, its counters can be
/// compared nevertheless. N_V itself is compared by our own rule.
fn sized_as_published<'g>(
    geometry: &'g Geometry<f64>,
    setting: &Setting,
    own: StructureStats,
) -> Result<Option<HugTracer<'g>>, ReproduceError> {
    let published = |name| setting.figures.get(name).and_then(|text| text.parse::<u64>().ok());
    let (Some(1), Some(cells)) = (published("N_IN"), published("N_V")) else { return Ok(None) };
    if own.inner_cells != 1 || own.cells == cells {
        return Ok(None);
    }
    let (mut few, mut enough) = (0, 8 * geometry.len());
    while few + 1 < enough {
        let n = few.midpoint(enough);
        let grid = build(geometry, setting.params, n)?;
        match grid.stats().cells.cmp(&cells) {
            Ordering::Less => few = n,
            Ordering::Equal => return Ok(Some(grid)),
            Ordering::Greater => enough = n,
        }
    }
    Ok(None)
}

#[cfg(test)]
mod tests {
    use super::super::published::{figures, geometry, table};
    use super::*;

    #[test]
    fn two_classes_have_the_published_cells_in_lattice_mount_and_tetra() {
        let figures = figures().unwrap();
        for name in ["lattice", "mount", "tetra"] {
            let geometry = geometry(name);
            let published = table(&figures, "hug", name);
            let (params, counters) = published.iter().find(|p| p.0 == "HNG=2 HCN=0").unwrap();
            let entry = registered("hug").unwrap();
            let params = entry.params(settings(params).unwrap()).unwrap();
            let stats = entry.build(geometry.prims(), &params).unwrap().stats();
            assert_eq!(stats.inner_cells.to_string(), counters["N_IN"], "{name}");
            assert_eq!(stats.cells.to_string(), counters["N_V"], "{name}");
        }
        assert!(settings("HNG=2 X=3").is_err());
    }

    #[test]
    fn grids_of_the_published_size_hold_as_many_references() {
        let figures = figures().unwrap();
        for (name, params, tolerance) in [
            ("lattice", "HNG=3 HCN=0", 0.0),
            ("mount", "HNG=3 HCN=0", 0.02),
            ("mount", "HNG=4 HCN=0", 0.002),
        ] {
            let geometry = geometry(name);
            let published = table(&figures, "hug", name);
            let (_, counters) = published.into_iter().find(|p| p.0 == params).unwrap();
            let setting = Setting { structure: "hug", params, scene: name, figures: counters };
            let own = build(&geometry, params, 0).unwrap();
            let grid = sized_as_published(&geometry, &setting, own.stats()).unwrap().unwrap();
            assert_eq!(grid.stats().cells.to_string(), setting.figures["N_V"], "{name} {params}");
            for (counter, ours) in
                [("N_EV", grid.stats().empty_cells), ("N_OIV", grid.stats().references)]
            {
                let value: f64 = setting.figures[counter].parse().unwrap();
                let off = (ours as f64 - value).abs();
                assert!(off <= tolerance * value, "{name} {params} {counter}: {ours}");
            }
        }
    }
}
