//! The published figures, embedded from `results/published/` as data; settings as published, and what
//! ours do in them.

use std::collections::BTreeMap;

use accel_core::Hit;
use accel_core::query::cells::NoCells;
use accel_core::query::counters::WorkCounters;
use accel_core::query::tracer::{ShadowCount, ShadowRule, Tracer};
use accel_core::structure::{BuildError, StructureStats};
use accel_core::structures::REGISTRY;
use measurement::plan::error::PlanError;
use measurement::plan::rows::Row;
use renderer::{Geometry, GeometryError, RayBatches, RayKind, RaySettings, generate_rays};
use scene_loading::Scene;
use scene_loading::procedural::{SpecError, generate_as_printed};
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
    #[serde(default = "invariants")]
    pub structure: String,
    /// Setting as the paper names it: `woo D=1.0`.
    #[serde(default)]
    pub params: String,
    pub scene: String,
    #[serde(alias = "invariant")]
    pub counter: String,
    pub value: String,
}

fn invariants() -> String {
    "invariants".to_owned()
}

/// All figures of the scenes we have, in the order of the files.
pub fn figures() -> Result<Vec<Figure>, csv::Error> {
    let mut all: Vec<Figure> = Vec::new();
    for file in [INVARIANTS, GRIDS, OCTREES] {
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

#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReproduceError {
    #[error("no counterpart for the published setting '{0}'")]
    UnknownSetting(String),
    #[error("results/published: {0}")]
    Figures(#[from] csv::Error),
    #[error(transparent)]
    Scene(#[from] SpecError),
    #[error(transparent)]
    Geometry(#[from] GeometryError),
    #[error(transparent)]
    Build(#[from] BuildError),
    #[error(transparent)]
    Plan(#[from] PlanError),
    #[error(transparent)]
    Cells(#[from] NoCells),
}

/// Counters in the paper's symbols.
pub(super) type PaperCounters = Vec<(&'static str, f64)>;

/// Counts one setting of a structure in a scene, given the figures published for it.
pub(super) type Counted = Result<PaperCounters, ReproduceError>;
pub(super) type Count = fn(&PublishedScene, &Setting) -> Counted;

/// A setting as published, with its figures.
pub(super) struct Setting<'f> {
    pub(super) structure: &'static str,
    pub(super) params: &'f str,
    pub(super) scene: &'f str,
    pub(super) figures: BTreeMap<&'f str, &'f str>,
}

/// A scene in the published setting: its rays, made once.
pub struct PublishedScene {
    pub(crate) geometry: Geometry<f64>,
    pub(crate) rays: RayBatches<f64>,
    lights: usize,
}

/// Work of a structure for all rays of a scene.
pub(crate) struct SceneWork {
    pub(crate) stats: StructureStats,
    pub(crate) counters: WorkCounters,
    pub(super) primary_hits: u64,
    pub(super) secondary_hits: u64,
    /// Blocked shadow rays, plus glass hit by the others.
    pub(super) shadow_hits: u64,
    pub(super) blocked: u64,
}

impl PublishedScene {
    pub fn new(name: &str) -> Result<Self, ReproduceError> {
        let scene: Scene = generate_as_printed(name)?;
        let geometry = Geometry::<f64>::of(&scene)?;
        let rays = {
            // any right structure gives the same rays; a fast one is taken
            let tracer = build("uniform-grid:density=8", &geometry)?;
            generate_rays(&scene, tracer.as_ref(), &RaySettings::published())
        };
        Ok(Self { geometry, rays, lights: scene.lights.len() })
    }

    /// AllRays: primary, shadow and secondary, untraced ones (total reflection) included.
    pub(crate) fn all_rays(&self) -> u64 {
        self.rays.total() as u64 + self.rays.total_internal_reflections
    }

    /// Counts what `tracer` does for all rays, shadow rays by this rule.
    pub(crate) fn count(
        &self,
        tracer: &dyn Tracer<f64>,
        rule: ShadowRule,
    ) -> Result<SceneWork, NoCells> {
        let mut counters = WorkCounters::default();
        let mut hits_of = |kinds: &[RayKind]| {
            let mut found = 0;
            for &kind in kinds {
                let rays = self.rays.rays(kind);
                let mut hits = vec![Hit::NONE; rays.len()];
                counters += tracer.count_closest_hits(rays, &mut hits);
                found += hits.iter().filter(|h| h.is_hit()).count() as u64;
            }
            found
        };
        let primary_hits = hits_of(&[RayKind::Primary]);
        let secondary_hits = hits_of(&[RayKind::Reflected, RayKind::Refracted]);
        let rays = self.rays.rays(RayKind::Shadow);
        let mut answers = vec![ShadowCount::default(); rays.len()];
        counters += tracer.count_historical(rays, rule, &mut answers)?;
        let shadow_hits =
            answers.iter().map(|a| if a.blocked { 1 } else { u64::from(a.glass) }).sum();
        let blocked = answers.iter().filter(|a| a.blocked).count() as u64;
        let stats = tracer.stats();
        Ok(SceneWork { stats, counters, primary_hits, secondary_hits, shadow_hits, blocked })
    }

    pub(super) fn invariants(&self, work: &SceneWork) -> PaperCounters {
        let of = |kind| self.rays.rays(kind).len() as u64;
        let secondary =
            of(RayKind::Reflected) + of(RayKind::Refracted) + self.rays.total_internal_reflections;
        let required = work.primary_hits + work.secondary_hits + work.shadow_hits;
        [
            ("PrimaryRay", of(RayKind::Primary)),
            ("UsedIntPrimRay", work.primary_hits),
            ("ShadowRay", of(RayKind::Shadow)),
            ("UsedIntShadRay", work.shadow_hits),
            ("SecondaryRay", secondary),
            ("UsedIntSecRay", work.secondary_hits),
            ("AllRays", self.all_rays()),
            ("IntersRequired", required),
            ("total_primitives", self.geometry.len() as u64),
            ("lights", self.lights as u64),
        ]
        .map(|(name, value)| (name, value as f64))
        .to_vec()
    }
}

pub(super) type BuiltTracer<'g> = Box<dyn Tracer<f64> + 'g>;

/// Builds a structure with its settings, as `uniform-grid:density=8`.
pub(super) fn build<'g>(
    row: &str,
    geometry: &'g Geometry<f64>,
) -> Result<BuiltTracer<'g>, ReproduceError> {
    let row = Row::parse(REGISTRY, row)?;
    Ok(row.entry.build(geometry.prims(), &row.params)?)
}

/// The counters of what was built in the paper's symbols.
pub(crate) fn cell_counters(stats: &StructureStats) -> [(&'static str, u64); 4] {
    [
        ("N_IN", stats.inner_cells),
        ("N_V", stats.cells),
        ("N_EV", stats.empty_cells),
        ("N_OIV", stats.references),
    ]
}

/// The same of a grid, and what its rays take, per ray.
pub(crate) fn grid_counters(scene: &PublishedScene, work: &SceneWork) -> PaperCounters {
    let of_rays = [
        ("N_IT", work.counters.intersection_tests),
        ("N_TS", work.counters.traversal_steps),
        ("N_ETS", work.counters.elementary_steps),
        ("N_EETS", work.counters.empty_elementary_steps),
    ];
    let of_cells = cell_counters(&work.stats).map(|(name, n)| (name, n as f64));
    let per_ray = of_rays.map(|(name, n)| (name, n as f64 / scene.all_rays() as f64));
    [of_cells, per_ray].concat()
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
            for column in crate::reproduce::settings::OCTREES {
                let octree = table(&all, column, scene);
                let params: Vec<_> = octree.iter().map(|(p, _)| *p).collect();
                assert_eq!(params, ["depth=4", "depth=5", "depth=6", "depth=7"], "{column}");
                assert!(octree.iter().all(|(_, counters)| counters.len() == 10), "{column}");
            }
        }
    }
}
