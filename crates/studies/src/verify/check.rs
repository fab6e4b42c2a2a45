//! All cases against all subjects, until a signal or the time ends the check.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering::SeqCst};
use std::time::Duration;

use accel_core::Ray;
use accel_core::registry::Buildable;
use accel_core::structure::BuildError;
use accel_core::structures::Entry;
use rayon::prelude::*;

use super::catalogue::{Case, CatalogueEntry, Draw};
use super::judge::{Judge, RoundVerdict};
use super::report::{Line, StopReason, SubjectCounts};
use super::round::{FEWEST_RAYS, MOST_RAYS, Round};
use super::subject::{Replay, Subject};
use measurement::plan::error::PlanError;
use measurement::settings::Precision;
use measurement::system::clock::Clock;
use measurement::system::progress::Progress;
use statistics::random::Random;

/// Rounds of a case that is asked for many rays, until rounds have [`MOST_RAYS`].
const ROUNDS: usize = 32;

pub const PRECISIONS: [Precision; 2] = [Precision::F32, Precision::F64];

pub struct CheckPlan<'r> {
    pub cases: Vec<CatalogueEntry>,
    pub registry: &'r [Entry],
    pub subjects: Vec<Subject<'r>>,
    /// Rays a case and precision.
    pub rays: usize,
    pub seed: u64,
}

impl CheckPlan<'_> {
    /// Rounds of all cases in both precisions.
    pub fn all_rounds(&self) -> u64 {
        let of_case = |(_, case): &CatalogueEntry| self.rounds(case).len() * PRECISIONS.len();
        self.cases.iter().map(of_case).sum::<usize>() as u64
    }

    /// Rays of each round of a case and precision.
    fn rounds(&self, case: &Case) -> Vec<usize> {
        let all = self.rays.div_ceil(case.share);
        let most = all.div_ceil(ROUNDS).clamp(FEWEST_RAYS, MOST_RAYS).div_ceil(case.share);
        (0..all.div_ceil(most)).map(|i| most.min(all - i * most)).collect()
    }

    /// Checks a case in a precision: a line for each subject that it asks, and the number of rounds
    /// that all of them were asked. Runs in the current rayon pool; the outcome does not depend on
    /// the number of threads, unless `watch` cuts it short.
    pub fn check(
        &self,
        (group, case): CatalogueEntry,
        precision: Precision,
        watch: &CheckWatch<'_>,
    ) -> Result<(Vec<Line>, u64), PlanError> {
        let subjects = Subject::select_for_case(case.rows, &self.subjects, self.registry)?;
        let sizes = self.rounds(case);
        if subjects.is_empty() {
            sizes.iter().for_each(|_| watch.progress.step(Duration::ZERO));
            return Ok((Vec::new(), sizes.len() as u64));
        }
        let tallies = (0_u64..)
            .zip(&sizes)
            .collect::<Vec<_>>()
            .into_par_iter()
            .map(|(number, &rays)| {
                if watch.cut().is_some() {
                    return vec![SubjectCounts::default(); subjects.len()];
                }
                let drawn = Drawing { id: case.id, seed: self.seed, number, rays };
                let of_round = match precision {
                    Precision::F32 => drawn.ask(case.single, &subjects, watch),
                    Precision::F64 => drawn.ask(case.double, &subjects, watch),
                };
                watch.progress.step(Duration::ZERO);
                of_round
            })
            .reduce(
                || vec![SubjectCounts::default(); subjects.len()],
                |mut all, more| {
                    all.iter_mut().zip(more).for_each(|(counts, more)| counts.add(more));
                    all
                },
            );
        let complete = tallies.iter().map(|tally| tally.rounds).min().unwrap_or_default();
        let told = |(tally, subject): (SubjectCounts, &Subject<'_>)| {
            let replay = |round: u64, ray| Replay {
                case: case.id.to_owned(),
                precision,
                seed: self.seed,
                round,
                rays: sizes.get(round as usize).copied().unwrap_or_default(),
                ray,
                subject: subject.label(),
            };
            Line::new(group.name, case.id, precision, subject, &tally, replay)
        };
        let asked = tallies.into_iter().zip(&subjects).filter(|(tally, _)| tally.rounds > 0);
        Ok((asked.map(told).collect(), complete))
    }
}

/// Watches over a check. What is being asked when it must end is asked to its end: one structure,
/// the rays of one round.
pub struct CheckWatch<'a> {
    clock: &'a dyn Clock,
    /// A reading of the clock.
    deadline: Option<Duration>,
    /// The number of the signal that came; 0: none did.
    signal: Arc<AtomicUsize>,
    /// A step for each round.
    pub progress: Progress,
}

impl<'a> CheckWatch<'a> {
    /// From now on; `signal` is 0 as long as none came.
    pub fn new(
        clock: &'a dyn Clock,
        limit: Option<Duration>,
        signal: Arc<AtomicUsize>,
        progress: Progress,
    ) -> Self {
        let deadline = limit.map(|limit| clock.now().saturating_add(limit));
        Self { clock, deadline, signal, progress }
    }

    /// Why the check must end, if it must.
    pub fn cut(&self) -> Option<StopReason> {
        match self.signal.load(SeqCst) {
            0 => {}
            signal => return Some(StopReason::Interrupted(signal)),
        }
        let is_late = self.deadline.is_some_and(|deadline| self.clock.now() >= deadline);
        is_late.then_some(StopReason::OutOfTime)
    }
}

/// Random source of the rays and scenes of a round.
#[derive(Debug, Clone, Copy)]
pub(super) struct Drawing<'c> {
    pub(super) id: &'c str,
    pub(super) seed: u64,
    pub(super) number: u64,
    pub(super) rays: usize,
}

impl Drawing<'_> {
    fn random(&self) -> Random {
        Random::new(self.seed, &format!("verify {} {}", self.id, self.number))
    }

    pub(super) fn drawn<S: Buildable>(&self, draw: Draw<S>) -> Result<Round<S>, String> {
        draw(&mut self.random(), self.rays).map_err(|e| e.to_string())
    }

    fn ask<S: Buildable>(
        &self,
        draw: Draw<S>,
        subjects: &[Subject<'_>],
        watch: &CheckWatch<'_>,
    ) -> Vec<SubjectCounts> {
        let failed = |what: String| {
            subjects.iter().map(|_| SubjectCounts::refused(self.number, what.clone())).collect()
        };
        let round = match self.drawn(draw) {
            Ok(round) => round,
            Err(error) => return failed(error),
        };
        match Judge::new(&round) {
            Ok(judge) => {
                let judged = |s| match watch.cut() {
                    None => SubjectCounts::of(self.number, round.rays.len(), judge.judge(s)),
                    Some(_) => SubjectCounts::default(),
                };
                subjects.iter().map(judged).collect()
            }
            Err(error) => failed(error.to_string()),
        }
    }
}

#[derive(Debug)]
pub struct ReplayOutcome {
    /// The ray and what was expected of it.
    pub question: String,
    /// Why the answer is wrong, or `None`.
    pub wrong: Option<String>,
    /// Why the scene was refused, if so.
    pub refused: Option<String>,
}

/// Repeats one trial of a case; `None` when its round has no such ray.
pub fn replay(
    case: &Case,
    line: &Replay,
    subject: &Subject<'_>,
) -> Result<Option<ReplayOutcome>, BuildError> {
    let &Replay { seed, round: number, rays, .. } = line;
    let drawing = Drawing { id: case.id, seed, number, rays };
    match line.precision {
        Precision::F32 => replay_round(line, drawing, case.single, subject),
        Precision::F64 => replay_round(line, drawing, case.double, subject),
    }
}

fn replay_round<S: Buildable>(
    replay: &Replay,
    drawing: Drawing<'_>,
    draw: Draw<S>,
    subject: &Subject<'_>,
) -> Result<Option<ReplayOutcome>, BuildError> {
    let Ok(round) = drawing.drawn(draw) else { return Ok(None) };
    let (Some(ray), Some(expected)) = (round.rays.get(replay.ray), round.expected.get(replay.ray))
    else {
        return Ok(None);
    };
    let (wrong, refused) = match Judge::new(&round)?.judge(subject) {
        RoundVerdict::Asked(all, _) => {
            let of_ray = all.into_iter().find(|m| m.ray == replay.ray && m.is_wrong);
            (of_ray.map(|m| m.what), None)
        }
        RoundVerdict::Refused(why) => (None, Some(why)),
        RoundVerdict::NotAsked => (None, Some("has no such primitives".to_owned())),
    };
    let Ray { origin, direction, t_min, t_max, .. } = ray;
    let question = format!(
        "ray from {origin:?} along {direction:?} in [{t_min:?}, {t_max:?}]\nexpected: {expected:?}"
    );
    Ok(Some(ReplayOutcome { question, wrong, refused }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use measurement::system::clock::SteppingClock;

    #[test]
    fn a_signal_and_the_limit_end_it() {
        let clock = SteppingClock::new(Duration::from_secs(1));
        let signal = Arc::new(AtomicUsize::new(0));
        let limit = Some(Duration::from_secs(3));
        let watch = CheckWatch::new(&clock, limit, Arc::clone(&signal), Progress::hidden());
        let cuts = [(); 3].map(|()| watch.cut());
        assert_eq!(cuts, [None, None, Some(StopReason::OutOfTime)]);
        signal.store(2, SeqCst);
        assert_eq!(watch.cut(), Some(StopReason::Interrupted(2)));
        let endless = CheckWatch::new(&clock, None, Arc::default(), Progress::hidden());
        assert_eq!(endless.cut(), None);
    }
}
