//! Timing the rows of a scene: interleaved rounds, each row built and asked anew in each.

use std::cell::Cell;
use std::collections::BTreeMap;
use std::time::Duration;

use accel_core::query::tracer::Foreign;
use accel_core::registry::Buildable;
use accel_core::structure::BuildError;
use renderer::{RayKind, Whitted};

use crate::answers::check::{RowCheck, stride_for};
use crate::answers::judge::judge;
use crate::plan::Plan;
use crate::plan::measured_row::{BuiltRow, MeasuredRow};
use crate::rays::batches::{Answers, BatchSet};
use crate::record::{RowRecord, Sample, Verdict};
use crate::rounds::interleaved::{Visit, interleaved, round_order};
use crate::rounds::scope::{Laps, RowLog, Scope};
use crate::system::clock::timed;
use crate::system::interrupt;
use crate::system::panics::caught;

/// Most rounds that a time budget buys.
const MOST_ROUNDS: usize = 10_000;

/// A sample of the rays and room for the answers to them.
struct Subsample<'a, S: Buildable> {
    set: BatchSet<'a, S>,
    answers: Vec<Answers<S>>,
}

/// Seconds by kind of ray and order.
type Seconds = BTreeMap<String, f64>;

/// Rounds over the rows that may be timed; `checked` has an entry for each row of the plan, whose
/// record gets its samples and the time of its image. One that panics, or whose process ends, is
/// left out from then on. The row `baseline` is the reference. `log` is told what each row does for
/// the first time.
pub fn measure<S: Buildable>(
    scope: &Scope<'_, '_, S>,
    checked: &mut [RowCheck],
    baseline: usize,
    deadline: Option<Duration>,
    log: &dyn RowLog,
) {
    let plan = scope.plan;
    let strides = strides(plan, &scope.stage.scene.name, checked, baseline);
    let rows = (0..plan.rows.len()).filter(|&row| strides[row].is_some()).collect();
    let (at_least, deadline) = match plan.processes {
        0 | 1 => (plan.rounds.at_least(), deadline),
        // fresh processes time the rows; here they are asked once
        _ => (1, None),
    };
    let schedule = Schedule { scope, log, baseline, strides, rows, at_least, deadline };
    let times = schedule.rounds(checked);
    times.keep_whole(&schedule.strides, checked);
    schedule.images(checked, &times);
}

/// The rows to time, the rays of each, and the number of rounds.
struct Schedule<'s, 'a, 'r, S: Buildable> {
    scope: &'s Scope<'a, 'r, S>,
    log: &'s dyn RowLog,
    baseline: usize,
    /// Stride of the rays of each row of the plan; `None` for rows that are not timed.
    strides: Vec<Option<usize>>,
    rows: Vec<usize>,
    at_least: usize,
    /// End of the time in which rounds beyond `at_least` begin; `None` without a budget.
    deadline: Option<Duration>,
}

struct RoundTimes {
    /// The reference's seconds on each sample of rays, by round.
    of_reference: Vec<BTreeMap<usize, Seconds>>,
    /// The round that a signal interrupted: some rows lack it.
    interrupted: Option<usize>,
}

impl<S: Buildable> Schedule<'_, '_, '_, S> {
    /// Returns whether another round begins after `rounds` of them.
    fn goes_on(&self, rounds: usize) -> bool {
        let has_time = || self.deadline.is_some_and(|deadline| self.scope.clock.now() < deadline);
        rounds < self.at_least || (rounds < MOST_ROUNDS && has_time())
    }

    fn rounds(&self, checked: &mut [RowCheck]) -> RoundTimes {
        let Self { scope, log, .. } = self;
        let (plan, first) = (scope.plan, scope.plan.process.first_round);
        let mut subsamples = thinned(scope, &self.strides);
        let mut of_reference = Vec::new();
        let interrupted = Cell::new(None);
        let goes_on = |round| {
            if round > first && plan.processes == 1 {
                interrupt::let_rounds_end();
            }
            interrupted.get().is_none() && self.goes_on(round - first)
        };
        let visit = |Visit { round, position, row }: Visit| {
            if interrupt::is_stopping() {
                interrupted.set(interrupted.get().or(Some(round)));
                return;
            }
            of_reference.resize_with(round + 1, BTreeMap::new);
            let row = self.rows[row];
            let (record, of_round) = (&mut checked[row].record, &mut of_reference[round]);
            let is_left = record.verdict.is_timed();
            let Some(stride) = self.strides[row].filter(|_| is_left) else { return };
            let is_baseline = row == self.baseline;
            let asked = RowVisit { row: &plan.rows[row], stride, is_baseline };
            if round == first {
                log.row_begins(&asked.row.label());
            } else {
                log.rows_passed();
            }
            match caught(|| asked.make(scope, &mut subsamples, of_round)) {
                Ok(Ok((sample, mismatches))) => {
                    record.stride = stride as u64;
                    // a structure may be wrong only sometimes
                    record.mismatches = record.mismatches.max(mismatches as u64);
                    let (round, position) = (round as u32, position as u32);
                    record.samples.push(Sample { round, position, ..sample });
                    scope.progress.step(scope.clock.now());
                }
                Ok(Err(died @ BuildError::Died(_))) => fail(record, died.to_string()),
                // it was built before, and cannot be built again
                Ok(Err(_)) => {}
                Err(panicked) => fail(record, panicked.to_string()),
            }
        };
        let (seed, scene) = (plan.seed, &scope.stage.scene.name);
        interleaved(first, self.rows.len(), seed, scene, goes_on, visit);
        interrupt::rounds_ended();
        log.rows_passed();
        RoundTimes { of_reference, interrupted: interrupted.get() }
    }

    /// Times the whole image of each row that is fast enough for it.
    fn images(&self, checked: &mut [RowCheck], times: &RoundTimes) {
        let Self { scope, log, .. } = self;
        let plan = scope.plan;
        let (rounds, scene) = (times.of_reference.len(), &scope.stage.scene.name);
        for i in round_order(plan.seed, scene, rounds, self.rows.len()) {
            let row = self.rows[i];
            let (planned, RowCheck { record, full_pass_s }) = (&plan.rows[row], &mut checked[row]);
            let seconds = *full_pass_s / plan.threads as f64;
            // an image would be timed with the way to its process and back
            let is_cheap = seconds <= plan.limits.render_pass && record.plugin.is_none();
            let is_whole = times.interrupted.is_none();
            if is_whole && is_cheap && !planned.is_sampled() && record.verdict.is_timed() {
                log.row_begins(&planned.label());
                match caught(|| render_once(scope, planned)) {
                    Ok(seconds) => record.render_s = seconds,
                    Err(panicked) => fail(record, panicked.to_string()),
                }
            }
            scope.progress.step(scope.clock.now());
        }
        log.rows_passed();
    }
}

/// One that panics once is not trusted any more.
fn fail(record: &mut RowRecord, why: String) {
    (record.verdict, record.error) = (Verdict::Panicked, Some(why));
}

impl RoundTimes {
    /// Drops the samples of an interrupted round. Adds to the others the seconds of the reference
    /// on the same rays in the same round.
    fn keep_whole(&self, strides: &[Option<usize>], checked: &mut [RowCheck]) {
        let whole = self.interrupted.unwrap_or(usize::MAX);
        for (RowCheck { record, .. }, stride) in checked.iter_mut().zip(strides) {
            let Some(stride) = stride else { continue };
            record.samples.retain(|sample| (sample.round as usize) < whole);
            for sample in &mut record.samples {
                let of_round = self.of_reference.get(sample.round as usize);
                let Some(seconds) = of_round.and_then(|round| round.get(stride)) else { continue };
                // over the kinds of rays that the row answers
                let own = seconds.iter().filter(|(kind, _)| sample.trace_s.contains_key(*kind));
                let own: Seconds = own.map(|(kind, s)| (kind.clone(), *s)).collect();
                sample.reference_trace_s = Some(own.values().sum());
                sample.reference_by_kind = own;
            }
        }
    }
}

/// Builds and asks rows as somebody else says, until no more is wanted; see [`measure`].
pub fn measure_laps<S: Buildable>(
    scope: &Scope<'_, '_, S>,
    checked: &[RowCheck],
    baseline: usize,
    laps: &dyn Laps,
) {
    let plan = scope.plan;
    let strides = strides(plan, &scope.stage.scene.name, checked, baseline);
    let mut subsamples = thinned(scope, &strides);
    while let Some(label) = laps.next() {
        let place = plan.rows.iter().position(|row| row.label() == label);
        let asked = place.and_then(|place| {
            let (row, stride) = (plan.rows.get(place)?, (*strides.get(place)?)?);
            Some(RowVisit { row, stride, is_baseline: false })
        });
        let seen = asked.and_then(|asked| {
            caught(|| asked.make(scope, &mut subsamples, &mut BTreeMap::new())).ok()?.ok()
        });
        laps.made(seen.map(|(sample, _)| sample).as_ref());
    }
}

/// A sample of the rays for each stride.
fn thinned<'a, S: Buildable>(
    scope: &Scope<'a, '_, S>,
    strides: &[Option<usize>],
) -> BTreeMap<usize, Subsample<'a, S>> {
    let mut subsamples = BTreeMap::new();
    for stride in strides.iter().flatten() {
        subsamples.entry(*stride).or_insert_with(|| {
            let set = scope.all.thinned(*stride);
            Subsample { answers: set.answers(), set }
        });
    }
    subsamples
}

/// Stride of the rays that each row is timed on; none for rows that are not timed. No row is timed
/// on more rays than the baseline, so that both can be timed on the same; where the plan wants the
/// same for all, no row on more than the slowest.
fn strides(
    plan: &Plan<'_>,
    scene: &str,
    checked: &[RowCheck],
    baseline: usize,
) -> Vec<Option<usize>> {
    let own = |(row, checked): (&MeasuredRow<'_>, &RowCheck)| {
        checked.record.verdict.is_timed().then_some(())?;
        let limits = &plan.limits;
        let cap = if row.is_sampled() { limits.sampled_pass } else { limits.timed_pass };
        let by_cost = || stride_for(checked.full_pass_s / plan.threads as f64, cap);
        Some(plan.strides.of_row(scene, &row.label()).timed.unwrap_or_else(by_cost))
    };
    let own: Vec<Option<usize>> = plan.rows.iter().zip(checked).map(own).collect();
    let least = if plan.same_rays {
        own.iter().copied().flatten().max()
    } else {
        own.get(baseline).copied().flatten()
    };
    let least = least.unwrap_or(1);
    own.into_iter().map(|stride| Some(stride?.max(least))).collect()
}

struct RowVisit<'a, 'r> {
    row: &'a MeasuredRow<'r>,
    stride: usize,
    is_baseline: bool,
}

impl RowVisit<'_, '_> {
    /// Builds the row and asks it. The baseline answers every other row's sample of rays as well,
    /// so that ratios are taken over the same rays in the same round. The times, and how many
    /// answers are not the ones expected. An error when the row, which was built before, cannot be
    /// built again, or ends its process.
    fn make<S: Buildable>(
        &self,
        scope: &Scope<'_, '_, S>,
        subsamples: &mut BTreeMap<usize, Subsample<'_, S>>,
        of_reference: &mut BTreeMap<usize, Seconds>,
    ) -> Result<(Sample, usize), BuildError> {
        let prims = scope.stage.geometry.prims();
        scope.pools.measured.install(|| {
            let build = self.row.prepare();
            let (built, build_s) = timed(scope.clock, || build(prims, scope.lights));
            let built = built?;
            let build_s = built.foreign().map_or(build_s, Foreign::build_seconds);
            let Some(subsample) = subsamples.get_mut(&self.stride) else {
                return Err(BuildError::NoPrimitives { structure: self.row.structure() });
            };
            let answers = |kind| self.row.answers(kind);
            let (trace_s, mismatches) = subsample.ask(&built, answers, scope);
            if self.is_baseline {
                of_reference.insert(self.stride, trace_s.clone());
                for (stride, subsample) in subsamples.iter_mut().filter(|(s, _)| **s != self.stride)
                {
                    of_reference.insert(*stride, subsample.ask(&built, answers, scope).0);
                }
            }
            built.alive()?;
            let process = scope.plan.process.number;
            Ok((Sample { process, build_s, trace_s, ..Sample::default() }, mismatches))
        })
    }
}

impl<S: Buildable> Subsample<'_, S> {
    /// Times a row on the batches that it answers; with several threads in chunks over them. Also
    /// how many of its answers are not the ones expected.
    fn ask(
        &mut self,
        built: &BuiltRow<'_, S>,
        is_asked: impl Fn(RayKind) -> bool,
        scope: &Scope<'_, '_, S>,
    ) -> (Seconds, usize) {
        let mut mismatches = 0;
        let mut seconds = Seconds::new();
        let batches = self.set.batches.iter().zip(&mut self.answers);
        for (batch, answers) in batches.filter(|(batch, _)| is_asked(batch.kind)) {
            answers.poison(&batch.expected);
            let took = built.timed(scope.clock, batch, answers, scope.plan.threads);
            seconds.insert(batch.name(), took);
            mismatches += judge(scope.stage, &self.set, batch, answers, built.exactness()).wrong;
        }
        (seconds, mismatches)
    }
}

/// Seconds of the whole image.
fn render_once<S: Buildable>(scope: &Scope<'_, '_, S>, row: &MeasuredRow<'_>) -> Option<f64> {
    // an occluder alone renders nothing
    let MeasuredRow::Structure(row) = row else { return None };
    let stage = scope.stage;
    scope.pools.measured.install(|| {
        let tracer = row.entry.build(stage.geometry.prims(), &row.params).ok()?;
        let draw = || Whitted::new(stage.scene, &scope.plan.settings).image(&*tracer, &|| ());
        let (image, seconds) = timed(scope.clock, draw);
        std::hint::black_box(image);
        Some(seconds)
    })
}
