//! All cases against all subjects, until a signal or the time ends the check.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering::SeqCst};
use std::time::Duration;

use accel_core::registry::Buildable;
use accel_core::structures::Entry;
use rayon::prelude::*;

use super::catalogue::{Case, CatalogueEntry, Draw};
use super::judge::{Judge, RoundVerdict};
use super::replay::RoundSeed;
use super::report::{Line, StopReason};
use super::round::{FEWEST_RAYS, MOST_RAYS};
use super::subject::Subject;
use measurement::plan::error::PlanError;
use measurement::settings::Precision;
use measurement::system::clock::Clock;
use measurement::system::progress::Progress;

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
        let empty = || -> Vec<Line> {
            subjects.iter().map(|s| Line::new(group.name, case.id, precision, s)).collect()
        };
        let of_round = |(i, &rays): (usize, &usize)| {
            let mut lines = empty();
            if watch.cut().is_none() {
                let number = i as u64;
                let round = RoundSeed { case, precision, seed: self.seed, number, rays };
                match precision {
                    Precision::F32 => ask(round, case.single, &subjects, &mut lines, watch),
                    Precision::F64 => ask(round, case.double, &subjects, &mut lines, watch),
                }
                watch.progress.step(Duration::ZERO);
            }
            lines
        };
        let of_rounds: Vec<Vec<Line>> = sizes.par_iter().enumerate().map(of_round).collect();
        let mut lines = empty();
        for of_round in of_rounds {
            lines.iter_mut().zip(of_round).for_each(|(line, more)| line.add(more));
        }
        let complete = lines.iter().map(|line| line.rounds).min().unwrap_or_default();
        lines.retain(|line| line.rounds > 0);
        Ok((lines, complete))
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

/// Adds the verdicts on the subjects to their lines, as far as there is time to ask them.
fn ask<S: Buildable>(
    round: RoundSeed,
    draw: Draw<S>,
    subjects: &[Subject<'_>],
    lines: &mut [Line],
    watch: &CheckWatch<'_>,
) {
    let drawn = round.drawn(draw).map_err(|e| e.to_string());
    let judge = match &drawn {
        Ok(drawn) => Judge::new(drawn).map_err(|e| e.to_string()),
        Err(why) => Err(why.clone()),
    };
    let rays = drawn.as_ref().map_or(0, |drawn| drawn.rays.len());
    for (line, subject) in lines.iter_mut().zip(subjects) {
        match &judge {
            Err(why) => line.count(round, rays, RoundVerdict::Refused(why.clone())),
            Ok(_) if watch.cut().is_some() => {}
            Ok(judge) => line.count(round, rays, judge.judge(subject)),
        }
    }
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
