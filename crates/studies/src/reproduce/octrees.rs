//! The five octree columns of Havran's second table: historical boxes, cells cut while they hold
//! more than one reference, lists turned round from level to level, maximal depths 4 to 7. At the
//! root they are as in the file for the traversal of 1984, reversed for the others.
//!
//! The letter tells the subdivision (centre or adaptive), the year the traversal: Glassner 1984,
//! Samet 1989, Gargantini and Atkinson 1993. Unlike in the grid tables, N_IT is per hit that was
//! required (IntersRequired), not per ray.
//!
//! The columns of 1993 begin every ray at 0.01, and count a leaf twice that holds primitives but
//! does not end the ray: once as a leaf, once more as an empty one. So N_ETS - N_EETS is the number
//! of leaves with primitives, and N_EETS that of all leaves but the one in which the ray ended.
//! Glass ends no shadow ray.

use accel_core::query::tracer::ShadowRule;
use renderer::Geometry;

use super::published::{
    BuiltTracer, Counted, PublishedScene, ReproduceError, Setting, build, grid_counters,
};

/// The columns, as named in the table.
pub const COLUMNS: [&str; 5] =
    ["Octree84-A", "Octree84-C", "Octree89-C", "Octree93-A", "Octree93-C"];

/// Builds the octree of a column at a published depth (`depth=6`) and counts: steps per ray, tests
/// per required hit.
pub(super) fn counters(scene: &PublishedScene, setting: &Setting) -> Counted {
    let tracer = build_octree(&scene.geometry, setting.structure, setting.params)?;
    let work = scene.count(tracer.as_ref(), ShadowRule::Historical);
    let required = work.primary_hits + work.secondary_hits + work.shadow_hits;
    let mut counters = grid_counters(scene, &work);
    // visits of leaves that hold primitives but end no ray: every ray that ends does so in one leaf
    let full = work.counters.elementary_steps - work.counters.empty_elementary_steps;
    let twice = full.saturating_sub(work.primary_hits + work.secondary_hits + work.blocked);
    let counts_twice = setting.structure.starts_with("Octree93");
    for (name, value) in &mut counters {
        match *name {
            "N_IT" => *value = work.counters.intersection_tests as f64 / required.max(1) as f64,
            "N_ETS" | "N_EETS" if counts_twice => *value += twice as f64 / scene.all_rays() as f64,
            _ => {}
        }
    }
    Ok(counters)
}

fn build_octree<'g>(
    geometry: &'g Geometry<f64>,
    column: &str,
    params: &str,
) -> Result<BuiltTracer<'g>, ReproduceError> {
    let subdivision = if column.ends_with("-A") { "adaptive" } else { "centre" };
    let traversal = match column.get(6..8) {
        Some("84") => "point-location",
        Some("89") => "neighbour",
        _ => "top-down",
    };
    let settings = [
        ("subdivision", subdivision),
        ("traversal", traversal),
        ("max-depth", params.strip_prefix("depth=").unwrap_or(params)),
        ("max-leaf", "1"),
        ("useless-splits", "20"),
        ("boxes", "historical"),
        ("order", if traversal == "point-location" { "alternate" } else { "alternate-reverse" }),
    ];
    build("octree", geometry, settings)
}

#[cfg(test)]
mod tests {
    use super::super::published::{cell_counters, figures, geometry, table};
    use super::super::reproduce_scene;
    use super::super::verdict::Verdict;
    use super::*;

    #[test]
    fn centre_subdivision_has_exactly_the_published_cells() {
        let figures = figures().unwrap();
        for scene in ["tetra", "balls"] {
            let geometry = geometry(scene);
            let columns = table(&figures, "Octree84-C", scene);
            assert_eq!(columns.len(), 4);
            for (params, counters) in columns {
                let stats = build_octree(&geometry, "Octree84-C", params).unwrap().stats();
                for (counter, value) in cell_counters(&stats) {
                    assert_eq!(value.to_string(), counters[counter], "{scene} {params} {counter}");
                }
            }
        }
    }

    #[test]
    fn steps_of_tetra_are_within_one_percent() {
        let columns = ["Octree84-C", "Octree89-C", "Octree93-C"];
        let rows = reproduce_scene("tetra", &columns, &figures().unwrap()).unwrap();
        assert_eq!(rows.len(), 3 * 4 * 8);
        for row in &rows {
            assert!((row.ratio - 1.0).abs() < 0.01, "{row:?}");
            assert!(matches!(row.verdict, Verdict::Exact | Verdict::Within), "{row:?}");
        }
    }
}
