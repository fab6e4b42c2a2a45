//! Is a row right, and what does it cost? Before anything of it is timed.

use accel_core::query::counters::WorkCounters;
use accel_core::query::tracer::Foreign;
use accel_core::registry::Buildable;
use accel_core::structure::BuildError;
use scene_loading::source_hash::sha256_of_bytes;

use crate::answers::judge::judge;
use crate::plan::measured_row::{BuiltRow, MeasuredRow};
use crate::rays::batches::{Answers, BatchSet};
use crate::record::{PluginRecord, RowRecord, StatsRecord, Verdict, WorkRecord};
use crate::rounds::scope::Scope;
use crate::system::clock::Clock;

/// Rays of a kind in the first and in the last step of a pilot.
const PILOT_RAYS: (usize, usize) = (16, 1024);
/// Seconds after which a pilot has seen enough of a kind.
const PILOT_SECONDS: f64 = 0.000_3;

/// A row as far as it is known before it is timed.
#[derive(Debug)]
pub struct RowCheck {
    /// Without times; of a row that cannot be measured nothing but the verdict and its reason.
    pub record: RowRecord,
    /// Seconds that one thread needs for all rays, estimated.
    pub full_pass_s: f64,
}

/// Builds a row, asks it all rays (or a sample where that takes too long) and compares.
///
/// # Errors
/// [`BuildError`] when it refuses the scene, or took more memory than it may.
pub fn check<S: Buildable>(
    scope: &Scope<'_, '_, S>,
    row: &MeasuredRow<'_>,
) -> Result<RowCheck, BuildError> {
    let prims = scope.stage.geometry.prims();
    let built = scope.pools.measured.install(|| row.prepare()(prims, scope.lights))?;
    let asked = scope.all.restricted(|kind| row.answers(kind));
    let full_pass_s = pilot(&built, &asked, scope.clock);
    built.alive()?;
    // the same rays in another order are compared in every round
    let asked = asked.distinct();
    let limits = &scope.plan.limits;
    let fixed = scope.plan.strides.of_row(&scope.stage.scene.name, &row.label()).checked;
    let stride = fixed.unwrap_or_else(|| {
        if row.is_sampled() {
            let tests = asked.total() as f64 * scope.stage.geometry.len() as f64;
            return stride_for(tests, limits.sampled_tests as f64);
        }
        stride_for(full_pass_s, limits.checked_pass)
    });
    let thinned = (stride != 1).then(|| asked.thinned(stride));
    let set = thinned.as_ref().unwrap_or(&asked);
    let mut work = WorkCounters::default();
    let (mut checked_rays, mut mismatches, mut edges) = (0, 0, 0);
    let mut examples = Vec::new();
    let mut answered = Vec::new();
    scope.pools.helper.install(|| {
        for batch in &set.batches {
            let mut timed_path = batch.unexpected();
            built.trace_chunked(batch, &mut timed_path);
            answered.extend_from_slice(batch.name().as_bytes());
            answered.extend(timed_path.bytes());
            let (counted_path, counted) = built.count(batch);
            work += counted;
            let timed = judge(scope.stage, set, batch, &timed_path, built.exactness());
            let counted = judge(scope.stage, set, batch, &counted_path, built.exactness());
            checked_rays += timed.compared;
            mismatches += timed.wrong.max(counted.wrong);
            edges += timed.edges.max(counted.edges);
            examples.extend(timed.example.or(counted.example));
        }
    });
    built.alive()?;
    let stats = stats(&built);
    // of what grew nobody knew before
    scope.plan.memory.allows(row.structure(), stats.memory_bytes.into())?;
    let verdict = match (mismatches, row.known_defect()) {
        (0, _) => Verdict::Ok,
        (_, Some(_)) => Verdict::WrongAsShipped,
        (_, None) => Verdict::Wrong,
    };
    let has_counters = built.foreign().is_none_or(Foreign::has_counters);
    let record = RowRecord {
        query: built.query(),
        stats: Some(stats),
        work: has_counters.then(|| WorkRecord::of(set.total(), &work)),
        checked_rays: checked_rays as u64,
        mismatches: mismatches as u64,
        answers_sha256: Some(sha256_of_bytes(&answered)),
        example: example(examples, built.foreign().is_some()),
        plugin: built.foreign().map(|f| PluginRecord::new(f, edges as u64)),
        ..row.unmeasured(verdict, None)
    };
    Ok(RowCheck { record, full_pass_s })
}

/// Examples of wrong answers: the first one; for a plugin, whose author must find the cause, the
/// first of each kind of ray.
fn example(mut examples: Vec<String>, is_foreign: bool) -> Option<String> {
    if !is_foreign {
        examples.truncate(1);
    }
    (!examples.is_empty()).then(|| examples.join("; "))
}

/// The stride to take so that a pass, in seconds or in tests, stays within the cap; a power of two,
/// so that rows share samples.
pub fn stride_for(full_pass: f64, cap: f64) -> usize {
    let wanted = (full_pass / cap).ceil();
    if wanted > 1.0 { (wanted.min(1e9) as usize).next_power_of_two() } else { 1 }
}

/// Seconds that one call a kind would take for all rays, from a few evenly spread ones.
fn pilot<S: Buildable>(built: &BuiltRow<'_, S>, set: &BatchSet<'_, S>, clock: &dyn Clock) -> f64 {
    let mut total = 0.0;
    for batch in &set.batches {
        let all = batch.rays.len();
        let mut wanted = PILOT_RAYS.0.min(all);
        loop {
            let stride = (all / wanted.max(1)).max(1);
            let few = batch.thinned(stride);
            let mut answers = Answers::new(batch.kind, few.rays.len());
            let mut ask = || built.timed(clock, &few, &mut answers, 1);
            // The first time warms up; the smaller of two more is free of most interruptions.
            ask();
            let seconds = ask().min(ask());
            if seconds >= PILOT_SECONDS || wanted >= PILOT_RAYS.1.min(all) {
                total += seconds / few.rays.len().max(1) as f64 * all as f64;
                break;
            }
            wanted = (wanted * 4).min(all);
        }
    }
    total
}

fn stats<S: Buildable>(built: &BuiltRow<'_, S>) -> StatsRecord {
    let stats = built.stats();
    StatsRecord {
        n_in: stats.inner_cells,
        n_v: stats.cells,
        n_ev: stats.empty_cells,
        n_oiv: stats.references,
        resolution: stats.resolution,
        memory_bytes: stats.bytes,
        pending_cells: stats.pending_cells,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strides_are_powers_of_two_that_keep_the_cap() {
        assert_eq!(stride_for(0.5, 1.0), 1);
        assert_eq!(stride_for(1.0, 1.0), 1);
        assert_eq!(stride_for(1.1, 1.0), 2);
        assert_eq!(stride_for(5.0, 1.0), 8);
        assert_eq!(stride_for(f64::NAN, 1.0), 1);
        assert!(stride_for(1e30, 1.0).is_power_of_two());
    }
}
