//! The published figures, embedded from `results/published/` as data.

use std::collections::BTreeMap;

use serde::Deserialize;

static GRIDS: &str = include_str!("../../published/havran1999_grids.csv");
static OCTREES: &str = include_str!("../../published/havran1999_octrees.csv");
static INVARIANTS: &str = include_str!("../../published/havran1999_invariants.csv");

/// Scenes we have; the paper's ninth, `fluid`, was never part of SPD and is not available.
pub const SCENES: [&str; 8] =
    ["balls", "gears", "lattice", "mount", "rings", "teapot", "tetra", "tree"];

#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct Figure {
    /// Structure as the paper names it: `uniform`; `invariants` for what no structure changes.
    pub structure: String,
    /// Setting as the paper names it: `woo D=1.0`.
    pub params: String,
    pub scene: String,
    pub counter: String,
    pub value: String,
}

#[derive(Deserialize)]
struct InvariantRecord {
    scene: String,
    invariant: String,
    value: String,
}

/// All figures of the scenes we have, in the order of the files.
///
/// # Errors
/// When an embedded file is damaged; names the line.
pub fn figures() -> Result<Vec<Figure>, csv::Error> {
    let mut all = Vec::new();
    for record in csv::Reader::from_reader(INVARIANTS.as_bytes()).deserialize() {
        let InvariantRecord { scene, invariant, value } = record?;
        let (structure, params) = ("invariants".to_owned(), String::new());
        all.push(Figure { structure, params, scene, counter: invariant, value });
    }
    for file in [GRIDS, OCTREES] {
        for record in csv::Reader::from_reader(file.as_bytes()).deserialize() {
            all.push(record?);
        }
    }
    all.retain(|f| SCENES.contains(&f.scene.as_str()));
    Ok(all)
}

/// The figures of one structure and scene: params -> counter -> value, params in file order.
pub fn table<'f>(
    figures: &'f [Figure],
    structure: &str,
    scene: &str,
) -> Vec<(&'f str, BTreeMap<&'f str, &'f str>)> {
    let mut table: Vec<(&str, BTreeMap<&str, &str>)> = Vec::new();
    for f in figures.iter().filter(|f| f.structure == structure && f.scene == scene) {
        if !table.iter().any(|(params, _)| *params == f.params) {
            table.push((&f.params, BTreeMap::new()));
        }
        if let Some((_, counters)) = table.iter_mut().find(|(params, _)| *params == f.params) {
            counters.insert(&f.counter, &f.value);
        }
    }
    table
}

/// The primitives of a scene, coordinates as SPD prints them.
#[cfg(test)]
pub(super) fn geometry(scene: &str) -> renderer::Geometry<f64> {
    let scene = scene_loading::procedural::generate_as_printed(scene).unwrap();
    renderer::Geometry::of(&scene).unwrap()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn embedded_figures_are_whole() {
        let all = figures().unwrap();
        for scene in SCENES {
            let [(_, invariants)] = &table(&all, "invariants", scene)[..] else {
                panic!("{scene}")
            };
            let of_rays = ["PrimaryRay", "ShadowRay", "SecondaryRay", "AllRays", "IntersRequired"];
            assert!(of_rays.iter().all(|name| invariants.contains_key(name)), "{scene}");
            let uniform = table(&all, "uniform", scene);
            let params: Vec<_> = uniform.iter().map(|(p, _)| *p).collect();
            assert_eq!(params, ["woo D=1.0", "woo D=10.0", "customary"]);
            assert!(uniform.iter().all(|(_, counters)| counters.len() == 11), "{scene}");
            for column in crate::reproduce::octrees::COLUMNS {
                let octree = table(&all, column, scene);
                let params: Vec<_> = octree.iter().map(|(p, _)| *p).collect();
                assert_eq!(params, ["depth=4", "depth=5", "depth=6", "depth=7"], "{column}");
                assert!(octree.iter().all(|(_, counters)| counters.len() == 10), "{column}");
            }
        }
    }
}
