//! One scene from loading to its record.

use crate::answers::arbiter::Arbiter;
use crate::answers::check::{RowCheck, check};
use crate::answers::reference::{Reference, Stage};
use crate::plan::measured_row::MeasuredRow;
use crate::plan::{Plan, default_rank};
use crate::rays::batches::BatchSet;
use crate::record::metrics::{builds_by_round, seconds_of};
use crate::record::{RowRecord, SceneRecord, Verdict};
use crate::rounds::MeasureError;
use crate::rounds::measure::{measure, measure_laps};
use crate::rounds::scope::{Laps, RowLog, Scope};
use crate::rounds::trial::TrialOutcome;
use crate::scenes::LoadedScene;
use crate::settings::Precision;
use crate::system::clock::Clock;
use crate::system::panics::caught;
use crate::system::pools::Pools;
use crate::system::progress::Progress;
use crate::system::world::World;
use accel_core::registry::Buildable;
use accel_core::structure::BuildError;
use glam::DVec3;
use renderer::{Geometry, RayKind, RaySettings, ShadowRays};
use scene_loading::Scene;
use std::collections::BTreeMap;
use std::time::Duration;

pub struct SceneInput<'a> {
    pub pools: &'a Pools,
    pub clock: &'a dyn Clock,
    pub world: &'a World,
    pub progress: &'a Progress,
    /// Outcome of the trial build of each row; empty without trial builds.
    pub trials: &'a [TrialOutcome],
    /// Told before each row is built for the first time.
    pub log: &'a dyn RowLog,
    /// Decides when each row is built and timed; `None` for rounds.
    pub laps: Option<&'a dyn Laps>,
}

/// Measures all rows of the plan on a scene, in the precision `S`. With a time budget, rounds go
/// on until `deadline`.
///
/// # Errors
/// [`MeasureError`] when the scene has no usable geometry or no structure can be built over it.
pub fn run_scene<S: Buildable>(
    plan: &Plan<'_>,
    loaded: &LoadedScene,
    equipment: &SceneInput<'_>,
    deadline: Option<Duration>,
) -> Result<SceneRecord, MeasureError> {
    (equipment.world.reset_peak_rss)();
    let (progress, scene) = (equipment.progress, &loaded.scene);
    progress.message(format!("{}: rays and oracle", scene.name));
    let exact = Geometry::<f64>::of(scene)?;
    let geometry = Geometry::<S>::of(scene)?;
    let built = Arbiter::new(&geometry, &exact);
    let arbiter = built.map_err(MeasureError::of_build(&scene.name))?;
    let stage = Stage { scene, geometry: &geometry, arbiter: &arbiter };
    let Reference { rays, answers, record: judged } = stage.reference(plan, equipment.pools)?;
    let lights = lights_asked(scene, &plan.settings);
    let all = BatchSet::new(&rays, answers, &lights);
    let all = all.in_orders(plan.orders, plan.seed, &scene.name);
    let scope = Scope {
        plan,
        stage: &stage,
        lights: &lights,
        all: &all,
        pools: equipment.pools,
        clock: equipment.clock,
        progress,
    };
    let mut checked = check_rows(&scope, equipment);
    let amended = arbiter.amended(&all);
    let scope = Scope { all: amended.as_ref().unwrap_or(&all), ..scope };
    if amended.is_some() {
        // rows that answered like the one that was contradicted passed
        checked = check_rows(&scope, equipment);
    }
    progress.message(format!("{}: timing", scene.name));
    let baseline = baseline(plan, &checked);
    match equipment.laps {
        None => measure(&scope, &mut checked, baseline, deadline, equipment.log),
        Some(laps) => measure_laps(&scope, &checked, baseline, laps),
    }
    let rows = plan.rows.iter().zip(checked);
    let mut rows: Vec<RowRecord> =
        rows.map(|(row, checked)| judged_by_rounds(&all, row, checked.record)).collect();
    if let Some(reference) = rows.get_mut(baseline) {
        reference.is_reference = true;
    }
    for (row, trial) in rows.iter_mut().zip(equipment.trials) {
        if let TrialOutcome::Ended { peak_bytes } = trial {
            row.peak_build_bytes = *peak_bytes;
        }
    }
    compare_with_baseline(&mut rows, baseline, plan.seed);
    Ok(SceneRecord {
        name: scene.name.clone(),
        sha256: loaded.sha256.clone(),
        source: loaded.source.clone(),
        licence: loaded.licence.clone(),
        primitives: geometry.len() as u64,
        geometry_bytes: geometry.bytes() as u64,
        only_triangles: Some(matches!(geometry, Geometry::Triangles(_))),
        warnings: match plan.precision {
            Precision::F32 => scene.warnings_in_f32().map(ToString::to_string).collect(),
            Precision::F64 => scene.warnings.iter().map(ToString::to_string).collect(),
        },
        origin: (scene.origin != DVec3::ZERO).then(|| scene.origin.to_array()),
        rays: by_kind(&all, |_| true),
        oracle: judged,
        rows,
        peak_rss_bytes: (equipment.world.peak_rss)(),
        ..SceneRecord::default()
    })
}

/// Checks each row of the plan, or says why it cannot be measured.
fn check_rows<S: Buildable>(scope: &Scope<'_, '_, S>, equipment: &SceneInput<'_>) -> Vec<RowCheck> {
    let check_row = |(i, row): (usize, &MeasuredRow<'_>)| {
        let refused = |verdict, reason| RowCheck {
            record: row.unmeasured(verdict, Some(reason)),
            full_pass_s: 0.0,
        };
        match equipment.trials.get(i) {
            Some(TrialOutcome::OverLimit(reason)) => {
                return refused(Verdict::OverLimit, reason.clone());
            }
            Some(TrialOutcome::Died(reason)) => return refused(Verdict::Panicked, reason.clone()),
            Some(TrialOutcome::Ended { .. }) | None => {}
        }
        let (scene, label) = (&scope.stage.scene.name, row.label());
        scope.progress.message(format!("{scene}: checking {label}"));
        equipment.log.row_begins(&label);
        let checked = match caught(|| check(scope, row)) {
            Ok(Ok(checked)) => checked,
            Ok(Err(error)) => refused(verdict_of(&error), error.to_string()),
            Err(panicked) => refused(Verdict::Panicked, panicked.to_string()),
        };
        scope.progress.step(scope.clock.now());
        checked
    };
    let rows = scope.plan.rows.iter().enumerate().map(check_row).collect();
    equipment.log.rows_passed();
    rows
}

/// Positions of the lights of a scene; centres of those with an extent.
pub fn light_positions(scene: &Scene) -> Vec<DVec3> {
    scene.lights.iter().map(|light| light.position).collect()
}

/// Positions of the lights that shadow rays run to: an occluder is built for these.
pub fn lights_asked(scene: &Scene, settings: &RaySettings) -> Vec<DVec3> {
    let mut lights = light_positions(scene);
    if settings.shadows == ShadowRays::FirstLight {
        lights.truncate(1);
    }
    lights
}

fn by_kind<S: Buildable>(
    set: &BatchSet<'_, S>,
    is_asked: impl Fn(RayKind) -> bool,
) -> BTreeMap<String, u64> {
    let asked = set.batches.iter().filter(|b| is_asked(b.kind));
    asked.map(|b| (b.name(), b.rays.len() as u64)).collect()
}

fn verdict_of(error: &BuildError) -> Verdict {
    match error {
        BuildError::Died(_) => Verdict::Panicked,
        BuildError::OutOfMemory(_) => Verdict::OutOfMemory,
        _ => Verdict::NotBuilt,
    }
}

/// The record of a row after all rounds: its answers were compared in each again.
fn judged_by_rounds<S: Buildable>(
    all: &BatchSet<'_, S>,
    row: &MeasuredRow<'_>,
    mut record: RowRecord,
) -> RowRecord {
    if record.verdict == Verdict::Ok && record.mismatches > 0 {
        let is_known = record.known_defect.is_some();
        record.verdict = if is_known { Verdict::WrongAsShipped } else { Verdict::Wrong };
    }
    if !record.verdict.is_timed() {
        record.samples.clear();
        record.render_s = None;
    }
    if !record.samples.is_empty() {
        let asked = by_kind(all, |kind| row.answers(kind)).into_iter();
        record.rays_by_kind = asked.map(|(kind, n)| (kind, n.div_ceil(record.stride))).collect();
    }
    record.rays = record.rays_by_kind.values().sum();
    record
}

/// Ratios to the baseline, round by round; none where the baseline was not timed.
fn compare_with_baseline(rows: &mut [RowRecord], baseline: usize, seed: u64) {
    let baseline: Vec<(u32, f64)> = match rows.get(baseline) {
        Some(row) if row.verdict.is_timed() => builds_by_round(row).collect(),
        _ => Vec::new(),
    };
    let is_timed = !baseline.is_empty();
    for row in rows {
        for sample in &mut row.samples {
            sample.reference_trace_s = sample.reference_trace_s.filter(|_| is_timed);
            sample.reference_build_s = seconds_of(sample.round, &baseline);
            sample.reference_by_kind.retain(|_, _| is_timed);
        }
        row.figure(seed);
    }
}

/// Index of the row, given what is known of each before it is timed. Where the planned one was not
/// built or is wrong without being known to be: the default references, the best first, else the
/// first row, of those that are right and answer all rays; others with known defects, and those
/// that are measured on a sample only, come last. The planned one if there is none, and where the
/// plan keeps it.
fn baseline(plan: &Plan<'_>, checked: &[RowCheck]) -> usize {
    let serves = |row: usize| checked.get(row).is_some_and(|c| c.record.verdict.is_timed());
    if plan.keeps_baseline || serves(plan.baseline) {
        return plan.baseline;
    }
    let others = plan.rows.iter().enumerate().filter(|(i, row)| serves(*i) && !row.is_occluder());
    let next = others.min_by_key(|(i, row)| {
        let rank = default_rank(row.structure(), &row.settings());
        let is_last = rank.is_none() && row.known_defect().is_some();
        (is_last, row.is_sampled(), rank.unwrap_or(usize::MAX), *i)
    });
    next.map_or(plan.baseline, |(i, _)| i)
}
