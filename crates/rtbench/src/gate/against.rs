//! Two binaries of rtbench, or one with two builds of a plugin, and a copy of the newer, as
//! contenders: the same rows and rays for each, and how many processes take turns.

use crate::comparison::pairing::Pairing;
use crate::comparison::renamed::Renaming;
use crate::gate::thresholds::Thresholds;
use measurement::answers::check::stride_for;
use measurement::record::RunRecord;
use measurement::system::child_process::{ChildError, answer, arguments, without_samples};
use std::collections::BTreeSet;
use std::ffi::OsString;
use std::path::PathBuf;
use std::process::Command;
use std::time::Duration;

/// Seconds that the rays of a kind may take in a lap, about; more are thinned. On a busy machine
/// a thread is interrupted every few milliseconds: most laps that are shorter are spared, and the
/// median is of those.
const PASS_SECONDS: f64 = 0.001;

#[derive(Debug, thiserror::Error)]
pub enum AgainstError {
    #[error("older: {0}")]
    Old(ChildError),
    #[error(transparent)]
    New(ChildError),
    #[error("cannot find the file of this program to run it in turns with the other")]
    NoProgram,
}

impl AgainstError {
    /// Error of the program at a place in [`Contest::programs`].
    pub fn of(place: usize) -> fn(ChildError) -> Self {
        if place == 0 { Self::Old } else { Self::New }
    }
}

/// A binary of rtbench, as it is started for a part of the work.
#[derive(Debug, Clone)]
pub struct Program {
    pub path: PathBuf,
    /// `--plugin FILE` and its settings.
    pub plugins: Vec<OsString>,
    /// Sources of scene files may lie outside their folders.
    pub allow_outside: bool,
}

impl Program {
    /// A child process with a task of `rtbench child`.
    pub fn child(&self, task: &str) -> Command {
        let mut command = Command::new(&self.path);
        command.args(arguments(self.allow_outside)).args(&self.plugins).arg(task);
        command
    }
}

/// The programs and what they measure.
#[derive(Debug)]
pub struct Contest {
    /// The older, the newer, which is this one, and a copy of this one.
    pub programs: [Program; 3],
    /// The record that says what to measure, with one round at least.
    pub like: RunRecord,
    pub pace: TurnPlan,
    /// Rows that the older calls otherwise.
    pub matches: Vec<Renaming>,
    /// They name kinds of rays that are timed apart.
    pub thresholds: Thresholds,
}

impl Contest {
    /// The old program's record of the same rows and rays, all answers checked, rows named as the
    /// newer does. Rows that it does not know are left out.
    pub fn record_of_old(&self) -> Result<RunRecord, AgainstError> {
        let [old, ..] = &self.programs;
        let asked = without_samples(&self.as_named_by(0, &self.like));
        let answered = answer(old.child("measure").args(["--rounds", "1"]), &asked);
        let mut record: RunRecord = answered.map_err(AgainstError::Old)?;
        self.matches.iter().for_each(|renamed| renamed.apply(&mut record));
        Ok(record)
    }

    /// Keeps of what is measured the rows that the old program has, too, and of these such as have
    /// times in both.
    pub fn keep_common(&mut self, old: &RunRecord) {
        let pairing = Pairing::of(old, &self.like);
        let timed = pairing.rows().filter(|pair| pair.rows.iter().all(|r| r.verdict.is_timed()));
        let common: BTreeSet<(String, String)> =
            timed.map(|pair| (pair.scenes[1].name.clone(), pair.rows[1].label())).collect();
        self.like.retain_rows(|scene, row| common.contains(&(scene.to_owned(), row.label())));
    }

    /// Thins the rays of slow rows, so that a pass over a kind is short.
    pub fn thin(&mut self) {
        // samples are made shorter likewise: they say how many laps a process has time for
        for row in self.like.scenes.iter_mut().flat_map(|s| &mut s.rows) {
            let kinds = row.samples.iter().flat_map(|s| s.trace_s.values());
            let longest = kinds.copied().max_by(f64::total_cmp).unwrap_or(0.0);
            let times = stride_for(longest, PASS_SECONDS);
            row.stride = row.stride.saturating_mul(times as u64);
            let seconds = row.samples.iter_mut().flat_map(|s| s.trace_s.values_mut());
            seconds.for_each(|s| *s /= times as f64);
        }
    }

    /// A record with rows as one of the programs calls them.
    pub fn as_named_by(&self, place: usize, like: &RunRecord) -> RunRecord {
        let mut like = like.clone();
        if place == 0 {
            self.matches.iter().for_each(|renamed| renamed.reversed().apply(&mut like));
        }
        like
    }
}

/// Rounds of a baseline and of a check where nothing is said. The rank test of 15 against 15 can
/// be significant among thousands of rows; that of the 5 of `run` cannot even be among ten.
pub const ROUNDS: u32 = 15;

/// Processes within a time budget, at the least: fewer could not be significant.
const FEWEST: u32 = 5;
/// Processes after which the laps so far are looked at, if more are to come.
const LOOKS: [u32; 6] = [5, 9, 15, 25, 40, 60];

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TurnPlan {
    /// Processes of each program; none asks for the default.
    pub rounds: Option<u32>,
    /// Time for all of them, where no number is said.
    pub time_budget: Option<Duration>,
    pub seed: u64,
}

impl TurnPlan {
    /// Processes of each program at the most, as far as is known.
    pub fn expected(&self) -> u32 {
        self.rounds.unwrap_or(ROUNDS)
    }

    /// Returns whether that process, from 0, is started so long after the first.
    pub fn goes_on(&self, process: u32, elapsed: Duration) -> bool {
        match self.time_budget {
            Some(budget) => process < FEWEST || elapsed < budget,
            None => process < self.expected(),
        }
    }

    /// How often laps are looked at, the end included.
    pub fn max_looks(&self) -> u32 {
        let is_before = |look: &&u32| self.time_budget.is_some() || **look < self.expected();
        1 + LOOKS.iter().filter(is_before).count() as u32
    }
}

/// Returns whether laps are looked at before that process, from 0, is started.
pub fn is_look(process: u32) -> bool {
    LOOKS.contains(&process)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn looks_at_the_results_are_counted() {
        let looks = |rounds, seconds| {
            let time_budget = Option::<u64>::map(seconds, Duration::from_secs);
            TurnPlan { rounds, time_budget, seed: 1 }.max_looks()
        };
        assert_eq!([looks(Some(2), None), looks(Some(9), None), looks(None, None)], [1, 2, 3]);
        assert_eq!(looks(None, Some(60)), 7);
    }
}
