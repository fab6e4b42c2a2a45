//! The rays of a scene for programs outside, and what is to be said of their answers.

use accel_core::{Hit, MISS, Ray};
use renderer::{Geometry, RayKind};

use crate::answers::arbiter::Arbiter;
use crate::answers::judge::{BatchVerdict, judge};
use crate::answers::reference::{Reference, Stage};
use crate::plan::Plan;
use crate::rays::batches::{Answers, BatchSet};
use crate::rays::exactness::Exactness;
use crate::record::{ForeignRecord, RowRecord, Verdict};
use crate::rounds::MeasureError;
use crate::rounds::scene_run::lights_asked;
use crate::rounds::scope::Scope;
use crate::scenes::LoadedScene;
use crate::system::clock::Clock;
use crate::system::pools::Pools;
use crate::system::progress::Progress;
use statistics::estimate::Estimate;

pub type RaysByKind = Vec<(RayKind, Vec<Ray<f32>>)>;

/// Answers by kind: the closest hit; for shadow rays any hit if blocked, else a miss.
pub type HitsByKind = Vec<(RayKind, Vec<Hit<f32>>)>;

/// The rays of a plan's kinds, as a run issues them.
///
/// # Errors
/// [`MeasureError`] for a scene without usable geometry, or one that no structure answers for.
pub fn rays(
    plan: &Plan<'_>,
    loaded: &LoadedScene,
    geometry: &Geometry<f32>,
    pools: &Pools,
) -> Result<RaysByKind, MeasureError> {
    with_reference(plan, loaded, geometry, pools, |reference, _| {
        let of = |kind: &RayKind| (*kind, reference.rays.rays(*kind).to_vec());
        plan.kinds.iter().map(of).collect()
    })
}

/// Judges the answers to these rays as those of a plugin with its own triangle test; one
/// [`BatchVerdict`] for each kind that has rays.
///
/// # Errors
/// As [`rays`].
pub fn check(
    plan: &Plan<'_>,
    loaded: &LoadedScene,
    geometry: &Geometry<f32>,
    (pools, clock): (&Pools, &dyn Clock),
    said: &HitsByKind,
) -> Result<Vec<(RayKind, BatchVerdict)>, MeasureError> {
    let progress = Progress::new(false, 0, None);
    with_reference(plan, loaded, geometry, pools, |Reference { rays, answers, .. }, stage| {
        let lights = lights_asked(stage.scene, &plan.settings);
        let all = BatchSet::new(&rays, answers, &lights);
        let scope =
            Scope { plan, stage, lights: &lights, all: &all, pools, clock, progress: &progress };
        let judged = all.batches.iter().map(|batch| {
            let own = said.iter().find(|(kind, _)| *kind == batch.kind);
            let hits = own.map(|(_, hits)| hits.as_slice()).unwrap_or_default();
            let answers = answers_of(batch.kind, hits, &batch.rays);
            (batch.kind, judge(&scope, &all, batch, &answers, Exactness::OwnTest))
        });
        judged.collect()
    })
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

/// Applies `then` to the rays and their answers.
fn with_reference<T>(
    plan: &Plan<'_>,
    loaded: &LoadedScene,
    geometry: &Geometry<f32>,
    pools: &Pools,
    then: impl FnOnce(Reference<f32>, &Stage<'_, f32>) -> T,
) -> Result<T, MeasureError> {
    let scene = &loaded.scene;
    let exact = Geometry::<f64>::of(scene)?;
    let arbiter = Arbiter::new(geometry, &exact)
        .map_err(|source| MeasureError::Build { scene: scene.name.clone(), source })?;
    let stage = Stage { scene, geometry, arbiter: &arbiter };
    let reference = stage.reference(plan, pools)?;
    Ok(then(reference, &stage))
}
