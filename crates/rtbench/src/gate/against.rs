//! Two binaries of rtbench, and a copy of the newer, as contenders: the same rows and rays for each.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::gate::contest::{Contender, Key, Pace, PairedTimes, Timed};
use measurement::answers::check::stride_for;
use measurement::record::{RowRecord, RunRecord};
use measurement::system::child_process::{ChildError, answer, arguments, without_samples};
use measurement::system::clock::Clock;
use measurement::system::progress::Progress;
use statistics::estimate::median;

/// Visits of each row in a process, as many as take [`VISIT_SECONDS`] within these bounds. The median
/// of their times counts, of each kind of rays by itself.
const VISITS: (u32, u32) = (5, 25);
/// Seconds of a process that are worth their time: starting it takes about as long.
const VISIT_SECONDS: f64 = 0.5;
/// Seconds that the rays of a kind may take in a process, about; more are thinned. On a busy machine
/// a thread is interrupted every few milliseconds: most visits that are shorter are spared, and the
/// median is of those.
const PASS_SECONDS: f64 = 0.001;

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

/// The binaries and what they measure.
#[derive(Debug)]
pub struct Contest<'a> {
    /// The older.
    pub old: &'a Path,
    /// The newer: this one.
    pub new: &'a Path,
    /// A copy of this one.
    pub copy: &'a Path,
    /// The record that says what to measure, with one round at least.
    pub like: RunRecord,
    /// How many turns.
    pub pace: Pace,
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

    /// Build and trace times of all rows that all have.
    ///
    /// # Errors
    /// [`AgainstError`].
    pub fn times(
        &self,
        clock: &dyn Clock,
        progress: &Progress,
    ) -> Result<Vec<PairedTimes>, AgainstError> {
        let like = thinned(&self.like);
        let visits = visits(&like);
        self.pace.take_turns(clock, progress, |contender| {
            let asked = |program| self.measured(program, &like, visits, true);
            let record = match contender {
                Contender::Old => asked(self.old).map_err(AgainstError::Old),
                Contender::New => asked(self.new).map_err(AgainstError::New),
                Contender::Copy => asked(self.copy).map_err(AgainstError::New),
            };
            record.map(|record| times_of(&record))
        })
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

/// The median build and trace times of all rows of a record.
pub fn times_of(record: &RunRecord) -> Vec<Timed> {
    let rows = record.scenes.iter().flat_map(|s| s.rows.iter().map(move |r| (s, r)));
    let times = rows.flat_map(|(scene, row)| {
        [("build", build(row)), ("trace", trace(row))].into_iter().filter_map(
            move |(quantity, s)| {
                let key = Key { scene: scene.name.clone(), row: row.label(), quantity };
                Some(Timed { key, seconds: s? })
            },
        )
    });
    times.collect()
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
