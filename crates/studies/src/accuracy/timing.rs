//! Timing the variants of an axis: interleaved rounds in seeded order, as rows of a run are; in one
//! process or in several, since where code and data lie is drawn once for a process, and moves times by
//! more than most variants differ. What cannot be is named as a fault.

use measurement::rounds::interleaved::{Visit, interleaved};
use measurement::system::clock::{self, Clock};

use crate::accuracy::pareto::{self, FrontPoint};
use crate::accuracy::record::{
    AxisRecord, ErrorOf, NO_TIME, PartTime, SceneOutcome, VariantRecord, VariantStanding,
};
use crate::accuracy::stage::{Batches, Limits, Replay, Stage, StagedStructure, Work, count};
use crate::error::StudyError;
use crate::images::TIMES_REFERENCE;

/// A variant, judged and ready to be timed.
pub struct Variant<'a> {
    pub record: VariantRecord,
    work: Box<dyn Work + 'a>,
}

impl<'a> Variant<'a> {
    /// A variant that is set otherwise than by a structure's parameters.
    pub fn new(
        name: impl Into<String>,
        setting: impl Into<String>,
        error: ErrorOf,
        work: impl Work + 'a,
    ) -> Self {
        let mut record = VariantRecord::new(name.into(), setting.into(), error);
        let part = |part: &&str| PartTime {
            part: (*part).to_owned(),
            seconds: Vec::new(),
            ratio: NO_TIME,
        };
        record.parts = work.parts().iter().map(part).collect();
        Self { record, work: Box::new(work) }
    }

    /// A structure with settings of its own.
    pub fn built(
        name: impl Into<String>,
        built: &StagedStructure<'_>,
        error: ErrorOf,
        work: impl Work + 'a,
    ) -> Self {
        Self::new(name, built.setting(), error, work).with_defect(built.known_defect)
    }

    #[must_use]
    pub fn with_defect(mut self, known_defect: Option<&'static str>) -> Self {
        self.record.known_defect = known_defect.map(Into::into);
        self
    }

    /// Sets whether it is the one that all others are compared with.
    #[must_use]
    pub fn as_reference(mut self, is_reference: bool) -> Self {
        self.record.is_reference = is_reference;
        self
    }

    /// Adds further figures, by name.
    #[must_use]
    pub fn also(mut self, figures: impl IntoIterator<Item = (&'static str, f64)>) -> Self {
        let figures = figures.into_iter().map(|(name, x)| (name.to_owned(), x));
        self.record.also.extend(figures);
        self
    }
}

/// Seconds of a timed pass, about: shorter work is repeated within it.
const PASS: f64 = 0.004;

fn repeats(seconds: f64) -> u32 {
    (PASS / seconds.max(1e-7)).ceil().clamp(1.0, 1000.0) as u32
}

/// Times the variants and says where each stands. `outcome` has what the axis found beside them.
pub fn timed<'v>(
    stage: &Stage<'_>,
    mut outcome: SceneOutcome,
    variants: impl IntoIterator<Item = Variant<'v>>,
) -> SceneOutcome {
    // all are made before the first one is timed
    let variants: Vec<Variant<'v>> = variants.into_iter().collect();
    let (mut rows, mut works) = (Vec::new(), Vec::new());
    for Variant { mut record, mut work } in variants {
        record.is_below_reference =
            record.error.value() < TIMES_REFERENCE * outcome.reference_error;
        rows.push(record);
        // the first run, which warms up, gives the answers that all others must repeat
        work.prepare();
        work.run();
        let answers = work.fingerprint();
        let ((), seconds) = clock::timed(stage.clock, || work.run());
        works.push((work, answers, repeats(seconds)));
    }
    let purpose = format!("{}/{}", stage.axis, stage.name);
    let Limits { rounds, seed, .. } = stage.limits;
    let is_left = |round| round < rounds;
    interleaved(0, works.len(), seed, &purpose, is_left, |Visit { row, .. }| {
        let (Some(row), Some((work, answers, repeats))) = (rows.get_mut(row), works.get_mut(row))
        else {
            return;
        };
        work.prepare();
        row.seconds.push(seconds(stage.clock, *repeats, &mut **work, &mut row.parts));
        if work.fingerprint() != *answers {
            // its time and its error would be those of two different programs
            let fault = format!("answers of {} differ between timing and judging", row.variant);
            if !outcome.faults.contains(&fault) {
                outcome.faults.push(fault);
            }
        }
    });
    outcome.rows = rows;
    stage.name.clone_into(&mut outcome.scene);
    figure(&mut outcome, seed);
    let found = faults(&outcome);
    outcome.faults.extend(found);
    outcome
}

/// Error of a variant, and further figures of it by name.
pub type ErrorFigures = (ErrorOf, Vec<(&'static str, f64)>);

/// Times structures that differ in a setting, each by its name and its label, on the same rays.
/// `judge` is given the number of each and the answers of all; `said` says whose rays they are and
/// through what they go.
pub fn timed_settings(
    stage: &Stage<'_>,
    settings: &[(&str, String)],
    reference: &str,
    batches: &Batches<f32>,
    mut said: SceneOutcome,
    judge: impl Fn(usize, &StagedStructure<'_>, &[Replay<'_, f32>]) -> Result<ErrorFigures, StudyError>,
) -> Result<SceneOutcome, StudyError> {
    let built = settings.iter().map(|(_, label)| stage.built(label));
    let built = built.collect::<Result<Vec<_>, StudyError>>()?;
    let replays: Vec<Replay<'_, f32>> =
        built.iter().map(|built| Replay::by_kind(&*built.tracer, batches)).collect();
    let judged = built.iter().enumerate().map(|(i, built)| judge(i, built, &replays));
    let judged = judged.collect::<Result<Vec<ErrorFigures>, StudyError>>()?;
    said.timed = format!("{} rays {}", count(batches), said.timed);
    let rows = settings.iter().zip(&built).zip(replays).zip(judged);
    let variants = rows.map(|((((name, _), built), replay), (error, figures))| {
        Variant::built(*name, built, error, replay).as_reference(*name == reference).also(figures)
    });
    Ok(timed(stage, said, variants))
}

/// Seconds of the work, made so many times; those of its parts are added to them.
fn seconds(clock: &dyn Clock, repeats: u32, work: &mut dyn Work, parts: &mut [PartTime]) -> f64 {
    let timed = |run: &mut dyn FnMut()| {
        let ((), seconds) = clock::timed(clock, || (0..repeats).for_each(|_| run()));
        seconds / f64::from(repeats)
    };
    if parts.is_empty() {
        return timed(&mut || work.run());
    }
    let mut sum = 0.0;
    for (i, part) in parts.iter_mut().enumerate() {
        let seconds = timed(&mut || work.run_part(i));
        part.seconds.push(seconds);
        sum += seconds;
    }
    sum
}

/// Cheapest variant from `first` on, by the median over common rounds. (Separate medians would
/// compare different rounds.)
fn cheapest(outcome: &SceneOutcome, first: usize) -> Option<&VariantRecord> {
    outcome.rows.iter().skip(first).reduce(|best, row| {
        let ratio = outcome.ratios(&row.seconds, &best.seconds).middle();
        if ratio.is_some_and(|ratio| ratio < 1.0) { row } else { best }
    })
}

/// Makes times, ratios and places of the variants from the seconds of their rounds.
pub fn figure(outcome: &mut SceneOutcome, seed: u64) {
    let variants_begin = outcome.rows.iter().take_while(|row| row.is_without).count();
    let cheapest = cheapest(outcome, variants_begin);
    let cheapest = cheapest.map(|row| row.seconds.clone()).unwrap_or_default();
    let first = outcome.rows.first().map(|row| row.parts.clone()).unwrap_or_default();
    let mut rows = std::mem::take(&mut outcome.rows);
    for row in &mut rows {
        let ratio = |seconds: &[f64], other: &[f64]| {
            outcome.ratios(seconds, other).estimate(seed).unwrap_or(NO_TIME)
        };
        row.time_s = outcome.series(&row.seconds).estimate(seed).unwrap_or(NO_TIME);
        row.ratio = ratio(&row.seconds, &cheapest);
        for (part, first) in row.parts.iter_mut().zip(&first) {
            part.ratio = ratio(&part.seconds, &first.seconds);
        }
    }
    let standings = pareto::standings(&places(&rows, outcome.reference_error));
    rows.iter_mut().zip(standings).for_each(|(row, standing)| row.standing = standing);
    outcome.rows = rows;
}

fn places(rows: &[VariantRecord], reference_error: f64) -> Vec<FrontPoint> {
    rows.iter().map(|row| FrontPoint::of(row, reference_error)).collect()
}

/// Takes the times of the axis that process number `process` (from 0) measured: those of the first
/// one in place of the axis' own, those of others beside them, of as many rounds each. Errors stay;
/// faults are added.
///
/// # Errors
/// [`StudyError::Unlike`] where the process has not measured the same variants on the same scenes.
pub fn join(
    axis: &mut AxisRecord,
    other: &AxisRecord,
    process: u32,
    seed: u64,
) -> Result<(), StudyError> {
    for scene in &mut axis.scenes {
        let same =
            other.scenes.iter().find(|o| (&o.scene, &o.subject) == (&scene.scene, &scene.subject));
        let unlike = |found: String| StudyError::Unlike {
            axis: axis.axis.clone(),
            place: scene.place(),
            process: process + 1,
            found,
        };
        let same = same.ok_or_else(|| unlike("nothing".into()))?;
        if let Some(found) = difference(scene, same, process) {
            return Err(unlike(found));
        }
        for (row, same) in scene.rows.iter_mut().zip(&same.rows) {
            take(&mut row.seconds, &same.seconds, process);
            for (part, same) in row.parts.iter_mut().zip(&same.parts) {
                take(&mut part.seconds, &same.seconds, process);
            }
        }
        let new = |fault: &&String| !scene.faults.contains(fault);
        let faults: Vec<String> = same.faults.iter().filter(new).cloned().collect();
        scene.faults.extend(faults);
        scene.processes = process + 1;
        figure(scene, seed);
    }
    Ok(())
}

fn take(seconds: &mut Vec<f64>, other: &[f64], process: u32) {
    if process == 0 {
        seconds.clear();
    }
    seconds.extend(other);
}

/// First difference from the outcome that it is merged into.
fn difference(scene: &SceneOutcome, other: &SceneOutcome, process: u32) -> Option<String> {
    let names = |of: &SceneOutcome| {
        let each = of.rows.iter().map(|row| (row.variant.clone(), row.parts.len()));
        each.collect::<Vec<_>>()
    };
    if names(scene) != names(other) {
        return Some(format!("other variants: {:?}", names(other)));
    }
    if scene.timed != other.timed {
        return Some(format!("timed {}", other.timed));
    }
    let rounds = |of: &SceneOutcome, processes: u32| {
        of.rows.first().map_or(0, |row| row.seconds.len()) / processes.max(1) as usize
    };
    (process > 0 && rounds(scene, process) != rounds(other, 1))
        .then(|| format!("{} rounds", rounds(other, 1)))
}

/// Impossible results, in words: a front with a member that another beats, a reference variant of an
/// exact oracle that is wrong.
fn faults(outcome: &SceneOutcome) -> Vec<String> {
    let standings: Vec<VariantStanding> = outcome.rows.iter().map(|row| row.standing).collect();
    let of_front = pareto::fault(&places(&outcome.rows, outcome.reference_error), &standings);
    let references = outcome.rows.iter().filter(|row| row.is_reference);
    let wrong = references.filter_map(|row| match row.error {
        ErrorOf::Counted { wrong, trials } if wrong > 0 => {
            Some(format!("{} is the reference and wrong in {wrong} of {trials}", row.variant))
        }
        _ => None,
    });
    of_front.into_iter().chain(wrong).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accuracy::record::made_up::{axis, row};

    #[test]
    fn the_cheapest_is_found_round_by_round() {
        // a machine that slows down: the second is faster in each round, the third never
        let seconds = [vec![2.0, 4.0, 8.0], vec![1.0, 3.9, 7.0], vec![2.5, 4.5, 6.9]];
        let mut outcome =
            axis(vec![row("a", 1.0, 0), row("b", 1.0, 0), row("c", 1.0, 0)]).scenes.remove(0);
        for (row, seconds) in outcome.rows.iter_mut().zip(seconds) {
            row.seconds = seconds;
        }
        assert_eq!(cheapest(&outcome, 0).unwrap().variant, "b");
        assert_eq!(cheapest(&outcome, 2).unwrap().variant, "c");
        assert_eq!((repeats(1.0), repeats(0.001), repeats(0.0)), (1, 4, 1000));
    }

    fn measured(times: [f64; 2]) -> AxisRecord {
        axis(vec![row("exact", times[0], 0), row("fast", times[1], 9)])
    }

    #[test]
    fn figures_are_over_processes_and_errors_stay() {
        let mut judged = measured([100.0, 1.0]);
        judged.scenes[0].rows[1].error = ErrorOf::Rmse { rmse: 0.5 };
        for (process, times) in [[2.0, 1.0], [8.0, 1.0]].into_iter().enumerate() {
            let mut other = measured(times);
            other.scenes[0].faults.push("it lies".into());
            join(&mut judged, &other, process as u32, 1).unwrap();
        }
        let scene = &judged.scenes[0];
        assert_eq!((scene.processes, &*scene.faults), (2, &["it lies".to_owned()][..]));
        let [exact, fast] = &scene.rows[..] else { panic!() };
        assert_eq!((exact.seconds.len(), fast.error.value()), (6, 0.5));
        assert!((exact.ratio.median - 4.0).abs() < 1e-9, "{:?}", exact.ratio);
        assert!(exact.ratio.high > 8.0, "of two processes alone: {:?}", exact.ratio);
    }

    #[test]
    fn processes_with_other_results_are_refused() {
        let refused = |judged: &mut AxisRecord, other: &AxisRecord, process| {
            join(judged, other, process, 1).unwrap_err().to_string()
        };
        let [mut judged, mut other] = [(); 2].map(|()| measured([1.0, 1.0]));
        other.scenes[0].rows.pop();
        assert!(refused(&mut judged, &other, 0).contains("other variants"));
        other.scenes.clear();
        let nothing = "process 1 measured nothing, which differs from what was judged";
        let error = refused(&mut judged, &other, 0);
        assert_eq!(error, format!("triangle-test on kitchen: {nothing}"));
        join(&mut judged, &measured([1.0, 1.0]), 0, 1).unwrap();
        let mut fewer = measured([1.0, 1.0]);
        fewer.scenes[0].timed = "100 rays".into();
        assert!(refused(&mut judged, &fewer, 1).contains("timed 100 rays"));
        let mut shorter = measured([1.0, 1.0]);
        shorter.scenes[0].rows[0].seconds.pop();
        assert!(refused(&mut judged, &shorter, 1).contains("2 rounds"));
    }
}
