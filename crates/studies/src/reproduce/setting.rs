//! Settings as published, and what ours do in them.

use std::collections::BTreeMap;

use accel_core::Hit;
use accel_core::params::ParamError;
use accel_core::query::counters::WorkCounters;
use accel_core::query::tracer::{ShadowCount, ShadowRule, Tracer};
use accel_core::structure::{BuildError, StructureStats};
use accel_core::structures::{Entry, find};
use renderer::{Geometry, GeometryError, RayBatches, RayKind, RaySettings, generate_rays};
use scene_loading::Scene;
use scene_loading::procedural::{SpecError, generate_as_printed};

/// Why a reproduction could not be made.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReproduceError {
    /// A published setting that has no counterpart here.
    #[error("no counterpart for the published setting '{0}'")]
    UnknownSetting(String),
    /// An embedded file of figures is damaged.
    #[error("results/published: {0}")]
    Figures(#[from] csv::Error),
    /// A scene could not be generated.
    #[error(transparent)]
    Scene(#[from] SpecError),
    /// A scene could not be converted.
    #[error(transparent)]
    Geometry(#[from] GeometryError),
    /// A structure could not be built.
    #[error(transparent)]
    Build(#[from] BuildError),
    #[error(transparent)]
    Param(#[from] ParamError),
    /// The registry lacks a structure.
    #[error("structure '{0}' is not in the registry")]
    Missing(&'static str),
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
    /// Generates the scene and its rays.
    pub fn new(name: &str) -> Result<Self, ReproduceError> {
        let scene: Scene = generate_as_printed(name)?;
        let geometry = Geometry::<f64>::of(&scene)?;
        let rays = {
            // any right structure gives the same rays; a fast one is taken
            let entry = registered("uniform-grid")?;
            let tracer = entry.build(geometry.prims(), &entry.params([("density", "8")])?)?;
            generate_rays(&scene, tracer.as_ref(), &RaySettings::published())
        };
        Ok(Self { geometry, rays, lights: scene.lights.len() })
    }

    /// AllRays: primary, shadow and secondary, untraced ones (total reflection) included.
    pub(crate) fn all_rays(&self) -> u64 {
        self.rays.total() as u64 + self.rays.total_internal_reflections
    }

    /// Counts what `tracer` does for all rays, shadow rays by this rule.
    pub(crate) fn count(&self, tracer: &dyn Tracer<f64>, rule: ShadowRule) -> SceneWork {
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
        let mut answers = vec![ShadowCount { blocked: false, glass: 0 }; rays.len()];
        counters += tracer.count_occlusions(rays, rule, &mut answers);
        let shadow_hits =
            answers.iter().map(|a| if a.blocked { 1 } else { u64::from(a.glass) }).sum();
        let blocked = answers.iter().filter(|a| a.blocked).count() as u64;
        let stats = tracer.stats();
        SceneWork { stats, counters, primary_hits, secondary_hits, shadow_hits, blocked }
    }

    /// The figures that no structure changes.
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

pub(crate) fn registered(name: &'static str) -> Result<&'static Entry, ReproduceError> {
    find(name).ok_or(ReproduceError::Missing(name))
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
