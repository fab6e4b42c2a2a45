//! Programs outside: the rays of a scene for them, what is to be said of their answers, and their row
//! in the results of a run (`rtbench rays check --into`).

use std::path::{Path, PathBuf};

use crate::context::Context;
use crate::error::Error;
use accel_core::primitives::TriangleSet;
use accel_core::{Hit, MISS, Ray};
use measurement::answers::arbiter::Arbiter;
use measurement::answers::judge::{BatchVerdict, judge};
use measurement::answers::reference::{Reference, Stage};
use measurement::plan::Plan;
use measurement::plan::error::PlanError;
use measurement::rays::batches::{Answers, BatchSet};
use measurement::rays::exactness::Exactness;
use measurement::rays::order::{distinct, kind_of};
use measurement::record::file::{self, RecordError};
use measurement::record::{ForeignRecord, RowRecord, RunRecord, SceneRecord, Verdict};
use measurement::rounds::MeasureError;
use measurement::rounds::scene_run::lights_asked;
use measurement::scenes::LoadedScene;
use measurement::settings::{Lights, RunSettings};
use measurement::system::machine;
use measurement::system::pools::Pools;
use plugins::files::FileSubject;
use renderer::{Geometry, RayKind};
use statistics::estimate::Estimate;

pub type RaysByKind = Vec<(RayKind, Vec<Ray<f32>>)>;

/// Answers by kind: the closest hit; for shadow rays any hit if blocked, else a miss.
pub type HitsByKind = Vec<(RayKind, Vec<Hit<f32>>)>;

/// A scene, and the rays that a run issues in it.
pub struct SceneRays<'r> {
    plan: Plan<'r>,
    pub loaded: LoadedScene,
    geometry: Geometry<f32>,
    pools: Pools,
}

impl<'r> SceneRays<'r> {
    pub fn load(context: &Context<'r>, settings: &RunSettings) -> Result<Self, Error> {
        let plan = Plan::new(settings, context.registry, context.occluders, context.scenes)?;
        let scene = plan.scenes.first().ok_or(PlanError::NoRows)?;
        let loaded = context.load(&**scene)?;
        let geometry = Geometry::of(&loaded.scene)?;
        Ok(Self { plan, loaded, geometry, pools: Pools::new(machine::threads())? })
    }

    /// The triangles of the scene, which must have nothing else.
    pub fn triangles(&self) -> Result<&TriangleSet<f32>, Error> {
        match &self.geometry {
            Geometry::Triangles(set) => Ok(set),
            _ => Err(Error::NotOfTriangles { scene: self.loaded.scene.name.clone() }),
        }
    }

    /// The rays of the plan's kinds, as a run issues them.
    pub fn rays(&self) -> Result<RaysByKind, Error> {
        self.with_reference(|reference, _| {
            let of = |kind: &RayKind| (*kind, reference.rays.rays(*kind).to_vec());
            self.plan.kinds.iter().map(of).collect()
        })
    }

    /// Judges the answers to these rays as those of a plugin with its own triangle test; one
    /// [`BatchVerdict`] for each kind that has rays.
    pub fn check(&self, said: &HitsByKind) -> Result<Vec<(RayKind, BatchVerdict)>, Error> {
        self.with_reference(|Reference { rays, answers, .. }, stage| {
            let lights = lights_asked(stage.scene, &self.plan.settings);
            let all = BatchSet::new(&rays, answers, &lights);
            let judged = all.batches.iter().map(|batch| {
                let own = said.iter().find(|(kind, _)| *kind == batch.kind);
                let hits = own.map(|(_, hits)| hits.as_slice()).unwrap_or_default();
                let answers = answers_of(batch.kind, hits, &batch.rays);
                (batch.kind, judge(stage, &all, batch, &answers, Exactness::OwnTest))
            });
            judged.collect()
        })
    }

    /// Applies `then` to the rays and their answers.
    fn with_reference<T>(
        &self,
        then: impl FnOnce(Reference<f32>, &Stage<'_, f32>) -> T,
    ) -> Result<T, Error> {
        let (scene, geometry) = (&self.loaded.scene, &self.geometry);
        let exact = Geometry::<f64>::of(scene)?;
        let built = Arbiter::new(geometry, &exact);
        let arbiter = built.map_err(MeasureError::of_build(&scene.name))?;
        let stage = Stage { scene, geometry, arbiter: &arbiter };
        Ok(then(stage.reference(&self.plan, &self.pools)?, &stage))
    }
}

fn answers_of(kind: RayKind, hits: &[Hit<f32>], rays: &[Ray<f32>]) -> Answers<f32> {
    if kind.is_occlusion() {
        return Answers::Blocked(hits.iter().map(Hit::is_hit).collect());
    }
    let own = |(hit, ray): (&Hit<f32>, &Ray<f32>)| {
        if hit.is_hit() { *hit } else { Hit { t: ray.t_max, id: MISS } }
    };
    Answers::Hits(hits.iter().zip(rays).map(own).collect())
}

/// The row of a program whose answers were judged, with the seconds that it reports, unless some
/// are wrong. There are no samples, no ratio and no interval: it was not in the rounds of the run.
pub fn foreign_row(
    name: &str,
    hits_sha256: String,
    [trace_s, build_s]: [Option<f64>; 2],
    judged: &[(RayKind, BatchVerdict)],
) -> RowRecord {
    let sum = |of: fn(&BatchVerdict) -> usize| -> u64 {
        judged.iter().map(|(_, judged)| of(judged) as u64).sum()
    };
    let mismatches = sum(|judged| judged.wrong);
    let verdict = if mismatches > 0 { Verdict::Wrong } else { Verdict::Ok };
    let reported = |s: Option<f64>| s.filter(|_| verdict.is_timed()).map(Estimate::exactly);
    let of_kind =
        |(kind, judged): &(RayKind, BatchVerdict)| (kind.name().to_owned(), judged.compared as u64);
    RowRecord {
        checked_rays: sum(|judged| judged.compared),
        mismatches,
        example: judged.iter().find_map(|(_, judged)| judged.example.clone()),
        rays: sum(|judged| judged.compared),
        rays_by_kind: judged.iter().map(of_kind).collect(),
        trace_s: reported(trace_s),
        build_s: reported(build_s),
        foreign: Some(ForeignRecord { hits_sha256, edge_mismatches: sum(|judged| judged.edges) }),
        ..RowRecord::unmeasured(name.to_owned(), String::new(), verdict)
    }
}

#[derive(Debug, thiserror::Error)]
pub enum ForeignRowError {
    #[error(transparent)]
    Record(#[from] RecordError),
    #[error("{}: the run is not finished; finish it with `rtbench run --resume`", path.display())]
    Incomplete { path: PathBuf },
    #[error("{}: no scene {scene} with this content; it has: {valid}", path.display())]
    NoScene { path: PathBuf, scene: String, valid: String },
    #[error("{}: its rays differ: {what}; export those of the run, with its options", path.display())]
    OtherRays { path: PathBuf, what: String },
    #[error("{}: scene {scene} has a row '{name}'; choose another --name, or replace a foreign row with --overwrite", path.display())]
    Taken { path: PathBuf, scene: String, name: String },
}

impl From<ForeignRowError> for Error {
    fn from(error: ForeignRowError) -> Self {
        Self::Other(Box::new(error))
    }
}

/// The results in a folder with a foreign row more, of the scene that is called `name` here and has
/// this content. One of its name is replaced where `overwrite` is set.
pub fn merged(
    folder: &Path,
    (name, sha256): (&str, &str),
    about: &FileSubject,
    row: RowRecord,
    overwrite: bool,
) -> Result<RunRecord, ForeignRowError> {
    let path = file::path_of(folder);
    let mut record = file::read(folder)?;
    if !record.complete {
        return Err(ForeignRowError::Incomplete { path });
    }
    let valid: Vec<&str> = record.scenes.iter().map(|scene| &*scene.name).collect();
    let valid = valid.join(", ");
    let what = other_settings(&record, about);
    let Some(scene) = record.scenes.iter_mut().find(|scene| scene.sha256 == sha256) else {
        return Err(ForeignRowError::NoScene { path, scene: name.to_owned(), valid });
    };
    if let Some(what) = what.or_else(|| other_counts(scene, about)) {
        return Err(ForeignRowError::OtherRays { path, what });
    }
    let is_same = |other: &RowRecord| other.label() == row.label();
    if scene.rows.iter().any(is_same) || scene.foreign.iter().any(is_same) && !overwrite {
        let (scene, name) = (scene.name.clone(), row.label());
        return Err(ForeignRowError::Taken { path, scene, name });
    }
    scene.foreign.retain(|other| !is_same(other));
    scene.foreign.push(row);
    Ok(record)
}

/// Differences of the settings of rays.
fn other_settings(record: &RunRecord, about: &FileSubject) -> Option<String> {
    let lights = if about.first_light { Lights::First } else { Lights::Each };
    let of = &record.settings;
    let pairs = [
        ("--size", format!("{}", of.resolution[0]), about.size.to_string()),
        ("--seed", of.seed.to_string(), about.seed.to_string()),
        ("--lights", of.lights.clone(), lights.name().to_owned()),
        ("--precision", of.precision.clone(), "f32".to_owned()),
    ];
    let differs = pairs.into_iter().find(|(_, run, file)| run != file);
    differs.map(|(name, run, file)| format!("{name} {file}, the run had {run}"))
}

/// A kind of which there are more or fewer rays.
fn other_counts(scene: &SceneRecord, about: &FileSubject) -> Option<String> {
    let asked = RayKind::ALL.into_iter().zip(about.rays).filter(|(_, n)| *n > 0);
    asked.into_iter().find_map(|(kind, n)| {
        let own = distinct(&scene.rays).find(|(name, _)| kind_of(name) == kind.name());
        let own = own.map_or(0, |(_, n)| n);
        (own != n).then(|| format!("{n} {} rays, the run had {own}", kind.name()))
    })
}
