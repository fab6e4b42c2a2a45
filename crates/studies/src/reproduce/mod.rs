//! `rtbench reproduce havran1999`: the published figures beside ours.
//!
//! V. Havran, F. Sixta, "Comparison of Hierarchical Grids", Ray Tracing News 12(1), 1999. What
//! the counters mean was found by experiment; `results/published/README.md` has the rules.
//! Everything is computed in f64 on coordinates as SPD prints them. Nothing is tuned per scene.

mod adaptive;
mod best;
mod hug;
pub mod lecture;
mod octrees;
pub mod published;
mod recursive;
mod uniform;
pub mod verdict;

use std::collections::BTreeMap;

use accel_core::Hit;
use accel_core::structures::{BuildError, Entry, Shape, find};
use accel_core::tracer::{ShadowCount, ShadowRule, Tracer};
use accel_core::{counters::WorkCounters, params::ParamError};
use rayon::prelude::*;
use renderer::{Geometry, GeometryError, RayBatches, RayKind, RaySettings, generate_rays};
use scene_loading::Scene;
use scene_loading::procedural::{SpecError, generate_as_printed};

use measurement::settings::suggest::hint;
use published::{Figure, SCENES, table};
use verdict::{Verdict, judge};

/// One figure, published and ours.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Row {
    /// Scene.
    pub scene: String,
    /// Structure as published.
    pub structure: String,
    /// Setting as published.
    pub params: String,
    /// Counter.
    pub counter: String,
    /// Published figure, as printed.
    pub published: String,
    /// Ours.
    pub ours: f64,
    /// Ours / published.
    pub ratio: f64,
    /// Judgement.
    #[serde(serialize_with = "as_text")]
    pub verdict: Verdict,
}

fn as_text<S: serde::Serializer>(v: &Verdict, s: S) -> Result<S::Ok, S::Error> {
    s.collect_str(v)
}

/// Why a reproduction could not be made.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReproduceError {
    /// No such scene in the paper.
    #[error("the paper has no scene '{0}' that we have{hint}; it has {valid}",
        hint = hint(.0, SCENES.iter().copied()), valid = SCENES.join(", "))]
    UnknownScene(String),
    /// No such scene in the lecture.
    #[error("the lecture has no scene '{0}'{hint}; it has {valid}",
        hint = hint(.0, lecture::SCENES.iter().copied()), valid = lecture::SCENES.join(", "))]
    NotInLecture(String),
    /// The lecture's ratios have one reference.
    #[error("--reference: ratios of the lecture are taken to {0}")]
    FixedReference(&'static str),
    /// No such structure among those reproduced.
    #[error("no published figures for structure '{0}'{hint}; there are {valid}",
        hint = hint(.0, structures()), valid = structures().join(", "))]
    UnknownStructure(String),
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
    /// A setting was refused.
    #[error(transparent)]
    Param(#[from] ParamError),
    /// The registry lacks a structure.
    #[error("structure '{0}' is not in the registry")]
    Missing(&'static str),
}

/// Counters in the paper's symbols.
type Counted = Vec<(&'static str, f64)>;

/// Counts one setting of a structure in a scene, given the figures published for it.
type Count = fn(&PublishedScene, &Setting) -> Result<Counted, ReproduceError>;

/// The structures of both tables as the paper names them, one line each.
static STRUCTURES: &[(&str, Count)] = &[
    ("invariants", |scene, _| Ok(scene.invariants(&uniform::count(scene, None)?))),
    ("uniform", uniform::counters),
    ("recursive", recursive::counters),
    ("hug", hug::counters),
    ("adaptive", adaptive::counters),
    ("adaptive-orphan", adaptive::counters),
    (octrees::COLUMNS[0], octrees::counters),
    (octrees::COLUMNS[1], octrees::counters),
    (octrees::COLUMNS[2], octrees::counters),
    (octrees::COLUMNS[3], octrees::counters),
    (octrees::COLUMNS[4], octrees::counters),
];

/// Names of what can be reproduced: the structures, and the table of their best settings.
pub fn structures() -> Vec<&'static str> {
    STRUCTURES.iter().map(|(name, _)| *name).chain([best::TABLE]).collect()
}

/// A setting as published, with its figures.
struct Setting<'f> {
    structure: &'static str,
    params: &'f str,
    scene: &'f str,
    figures: BTreeMap<&'f str, &'f str>,
}

/// A scene in the published setting: its rays, made once.
pub struct PublishedScene {
    pub(crate) geometry: Geometry<f64>,
    pub(crate) rays: RayBatches<f64>,
    lights: usize,
}

/// What a structure did for all rays of a scene.
pub(crate) struct Work {
    pub(crate) shape: Shape,
    pub(crate) counters: WorkCounters,
    /// Primary, secondary: hits.
    primary_hits: u64,
    secondary_hits: u64,
    /// Blocked shadow rays, plus glass hit by the others.
    shadow_hits: u64,
}

impl PublishedScene {
    /// Generates the scene and its rays.
    ///
    /// # Errors
    /// [`ReproduceError`].
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
    pub(crate) fn count(&self, tracer: &dyn Tracer<f64>, rule: ShadowRule) -> Work {
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
        Work { shape: tracer.shape(), counters, primary_hits, secondary_hits, shadow_hits }
    }

    /// The figures that no structure changes.
    fn invariants(&self, work: &Work) -> Counted {
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

/// The counters of a grid in the paper's symbols; those of rays per ray.
pub(crate) fn grid_counters(scene: &PublishedScene, work: &Work) -> Counted {
    let per_ray = |n: u64| n as f64 / scene.all_rays() as f64;
    vec![
        ("N_IN", work.shape.inner_cells as f64),
        ("N_V", work.shape.cells as f64),
        ("N_EV", work.shape.empty_cells as f64),
        ("N_OIV", work.shape.references as f64),
        ("N_IT", per_ray(work.counters.intersection_tests)),
        ("N_TS", per_ray(work.counters.traversal_steps)),
        ("N_ETS", per_ray(work.counters.elementary_steps)),
        ("N_EETS", per_ray(work.counters.empty_elementary_steps)),
    ]
}

/// Reproduces the figures of one scene for the structures asked for, in the paper's order.
///
/// # Errors
/// [`ReproduceError`].
pub fn reproduce_scene(
    scene: &str,
    structures: &[&str],
    figures: &[Figure],
) -> Result<Vec<Row>, ReproduceError> {
    let published = PublishedScene::new(scene)?;
    let mut tasks = Vec::new();
    for (structure, count) in STRUCTURES.iter().filter(|(name, _)| structures.contains(name)) {
        for (params, figures) in table(figures, structure, scene) {
            let setting = Setting { structure, params, scene, figures };
            tasks.push(Task { count: *count, of: setting, shown_as: None });
        }
    }
    if structures.contains(&best::TABLE) {
        for (params, of_best) in table(figures, best::TABLE, scene) {
            let best = Setting { structure: best::TABLE, params, scene, figures: of_best };
            let unknown = || ReproduceError::UnknownSetting(format!("best {params}"));
            let (count, of) = best::repeated(figures, &best).ok_or_else(unknown)?;
            tasks.push(Task { count, of, shown_as: Some(best) });
        }
    }
    let rows = tasks
        .par_iter()
        .map(|task| Ok(task.compare(&(task.count)(&published, &task.of)?)))
        .collect::<Result<Vec<_>, ReproduceError>>()?;
    Ok(rows.concat())
}

/// A setting to count.
struct Task<'f> {
    count: Count,
    of: Setting<'f>,
    /// The setting of the table of the best that repeats it.
    shown_as: Option<Setting<'f>>,
}

impl Task<'_> {
    /// Puts our counters beside the published ones; what is repeated is judged as what it repeats.
    fn compare(&self, ours: &Counted) -> Vec<Row> {
        let shown = self.shown_as.as_ref().unwrap_or(&self.of);
        ours.iter()
            .filter_map(|&(counter, ours)| {
                let text = shown.figures.get(counter)?;
                let value: f64 = text.parse().unwrap_or(f64::NAN);
                let Setting { structure, params, scene, .. } = self.of;
                Some(Row {
                    scene: scene.to_owned(),
                    structure: shown.structure.to_owned(),
                    params: shown.params.to_owned(),
                    counter: counter.to_owned(),
                    published: (*text).to_owned(),
                    ours,
                    ratio: if value == 0.0 && ours == 0.0 { 1.0 } else { ours / value },
                    verdict: judge(structure, params, scene, counter, text, ours),
                })
            })
            .collect()
    }
}
