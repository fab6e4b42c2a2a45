//! Two binaries measured in turns: pairs of processes, old and new in seeded random order.
//!
//! What drifts while the job runs then falls on both, and where code and memory happen to lie is
//! drawn anew in each process instead of once for all rounds.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use serde::Serialize;

use measurement::answers::check::stride_for;
use measurement::record::{RowRecord, RunRecord};
use measurement::system::child_process::{ChildError, answer, arguments, without_samples};
use measurement::system::clock::Clock;
use measurement::system::progress::Progress;
use statistics::estimate::median;
use statistics::random::Random;

/// Rounds of a baseline and of a check where nothing is said. The rank test of 15 against 15 can
/// be significant among thousands of rows; that of the 5 of `run` cannot even be among ten.
pub const ROUNDS: u32 = 15;

/// Visits of each row in a process, as many as take [`VISIT_SECONDS`] within these bounds. The median
/// of their times counts, of each kind of rays by itself.
const VISITS: (u32, u32) = (5, 25);
/// Seconds of a process that are worth their time: starting it takes about as long.
const VISIT_SECONDS: f64 = 0.5;
/// Seconds that the rays of a kind may take in a process, about; more are thinned. On a busy machine
/// a thread is interrupted every few milliseconds: most visits that are shorter are spared, and the
/// median is of those.
const PASS_SECONDS: f64 = 0.001;
/// Pairs within a time budget, at the least: fewer could not be significant.
const FEWEST: u32 = 9;

/// Why two binaries could not be compared.
#[derive(Debug, thiserror::Error)]
pub enum AgainstError {
    /// The other binary.
    #[error("--against: {0}")]
    Old(ChildError),
    /// This one.
    #[error(transparent)]
    New(ChildError),
    /// This program's own file is not known.
    #[error("cannot tell where the file of this program is, to start it in turns with the other")]
    NoProgram,
}

/// Times of a row, old and new of each pair, seconds.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PairedRow {
    /// Scene.
    pub scene: String,
    /// Structure.
    pub structure: String,
    /// What differs from its defaults.
    pub settings: String,
    /// Build.
    pub build: Vec<[f64; 2]>,
    /// Trace.
    pub trace: Vec<[f64; 2]>,
}

/// Two binaries and what they measure.
#[derive(Debug)]
pub struct Contest<'a> {
    /// The older.
    pub old: &'a Path,
    /// The newer: this one.
    pub new: &'a Path,
    /// The record that says what to measure, with one round at least.
    pub like: RunRecord,
    /// Pairs; none asks for the default.
    pub rounds: Option<u32>,
    /// Time for all pairs.
    pub time_budget: Option<Duration>,
    /// Sources of scene files may lie outside their folders.
    pub allow_outside: bool,
}

impl Contest<'_> {
    /// The old binary's record of the same rows and rays, all answers checked.
    ///
    /// # Errors
    /// [`AgainstError`].
    pub fn record_of_old(&self) -> Result<RunRecord, AgainstError> {
        self.measured(self.old, &self.like, 1, false).map_err(AgainstError::Old)
    }

    /// Pairs of processes, until there are as many as asked for.
    ///
    /// # Errors
    /// [`AgainstError`].
    pub fn pairs(
        &self,
        clock: &dyn Clock,
        progress: &Progress,
    ) -> Result<Vec<PairedRow>, AgainstError> {
        let mut rows: Vec<PairedRow> = Vec::new();
        let like = thinned(&self.like);
        let visits = visits(&like);
        let start = clock.now();
        let mut round = 0;
        while self.goes_on(round, clock.now().saturating_sub(start)) {
            progress.message(format!("pair {}", round + 1));
            let purpose = format!("pairs/{round}");
            let old_first = Random::new(self.like.settings.seed, &purpose).below(2) == 0;
            let old = || self.measured(self.old, &like, visits, true).map_err(AgainstError::Old);
            let new = || self.measured(self.new, &like, visits, true).map_err(AgainstError::New);
            let (old, new) = if old_first {
                let old = old()?;
                (old, new()?)
            } else {
                let new = new()?;
                (old()?, new)
            };
            add(&mut rows, &old, &new);
            round += 1;
            progress.step(clock.now());
        }
        Ok(rows)
    }

    /// Pairs that will be made, as far as is known.
    pub fn expected(&self) -> u32 {
        self.rounds.unwrap_or(ROUNDS)
    }

    fn goes_on(&self, round: u32, elapsed: Duration) -> bool {
        match self.time_budget {
            Some(budget) => round < FEWEST || elapsed < budget,
            None => round < self.expected(),
        }
    }

    fn measured(
        &self,
        program: &Path,
        like: &RunRecord,
        rounds: u32,
        lightly: bool,
    ) -> Result<RunRecord, ChildError> {
        let mut command = Command::new(program);
        command.args(arguments(self.allow_outside)).args([
            "measure",
            "--rounds",
            &rounds.to_string(),
        ]);
        if lightly {
            command.arg("--lightly");
        }
        answer(&mut command, &without_samples(like))
    }
}

/// The record with the rays of slow rows thinned, by powers of two, so that a pass over a kind is
/// short. Its samples are made shorter likewise, for [`visits`].
fn thinned(like: &RunRecord) -> RunRecord {
    let mut like = like.clone();
    for row in like.scenes.iter_mut().flat_map(|s| &mut s.rows) {
        let kinds = row.samples.iter().flat_map(|s| s.trace_s.values());
        let longest = kinds.copied().max_by(f64::total_cmp).unwrap_or(0.0);
        let times = stride_for(longest, PASS_SECONDS);
        row.stride = row.stride.saturating_mul(times as u64);
        let seconds = row.samples.iter_mut().flat_map(|s| s.trace_s.values_mut());
        seconds.for_each(|s| *s /= times as f64);
    }
    like
}

/// Visits of each row in a process.
fn visits(like: &RunRecord) -> u32 {
    let samples = || like.scenes.iter().flat_map(|s| &s.rows).flat_map(|r| &r.samples);
    let seconds: f64 = samples().map(|s| s.build_s + s.total_trace_s()).sum();
    let visits = (VISIT_SECONDS / seconds.max(1e-6)).ceil().min(f64::from(VISITS.1));
    (visits as u32).max(VISITS.0)
}

/// Adds the pair of times of each row that both have.
fn add(rows: &mut Vec<PairedRow>, old: &RunRecord, new: &RunRecord) {
    for (scene, row) in new.scenes.iter().flat_map(|s| s.rows.iter().map(move |r| (s, r))) {
        let of_old = old.scenes.iter().find(|s| s.name == scene.name);
        let of_old = of_old.and_then(|s| s.rows.iter().find(|r| r.is_same(row)));
        let Some(pair) = of_old.and_then(|old| pair(old, row)) else { continue };
        let at = rows.iter().position(|p| {
            let same = p.structure == row.structure && p.settings == row.settings;
            p.scene == scene.name && same
        });
        let (build, trace) = pair;
        match at.and_then(|i| rows.get_mut(i)) {
            Some(known) => {
                known.build.push(build);
                known.trace.push(trace);
            }
            None => rows.push(PairedRow {
                scene: scene.name.clone(),
                structure: row.structure.clone(),
                settings: row.settings.clone(),
                build: vec![build],
                trace: vec![trace],
            }),
        }
    }
}

/// The median times of the row on both sides: build, trace.
fn pair(old: &RowRecord, new: &RowRecord) -> Option<([f64; 2], [f64; 2])> {
    Some(([build(old)?, build(new)?], [trace(old)?, trace(new)?]))
}

fn build(row: &RowRecord) -> Option<f64> {
    median(&row.samples.iter().map(|s| s.build_s).collect::<Vec<_>>())
}

/// The median trace times of all kinds of rays together.
fn trace(row: &RowRecord) -> Option<f64> {
    let of = |kind| {
        let seconds = row.samples.iter().filter_map(|s| s.trace_s.get(kind).copied());
        median(&seconds.collect::<Vec<_>>())
    };
    row.samples.first()?.trace_s.keys().map(of).sum()
}

/// The file of this program, as the environment has it.
///
/// # Errors
/// [`AgainstError::NoProgram`].
pub fn own_program(program: Option<&PathBuf>) -> Result<&Path, AgainstError> {
    program.map(PathBuf::as_path).ok_or(AgainstError::NoProgram)
}
