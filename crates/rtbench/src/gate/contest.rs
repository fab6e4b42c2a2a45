//! Programs measured in turns: an old one, a new one, and a copy of the new one's file.
//!
//! A process of each stands ready with the scene, its rays and its rows. For each row the three
//! make a lap, one after the other: a build and a pass over the rays, by the processor's time, a
//! few milliseconds apart, so that whatever disturbs them disturbs all three. Orders are random,
//! each the reverse of the one before: of any two programs each is first equally often. After a
//! second or so three fresh processes follow, in which code and memory lie elsewhere. What counts
//! is what processes say: the ratios within laps, and of these the median of each process.
//!
//! After some processes the laps so far are looked at. Rows that are decided are asked no more, and
//! when all are, the contest is over. Each look is a chance for a false alarm, so the significance
//! is divided by their number (Bonferroni). What the copy differs by is the floor: no smaller
//! difference is claimed.

use std::collections::{BTreeMap, BTreeSet};
use std::io::{BufRead, BufReader, Read, Write};
use std::path::PathBuf;
use std::process::{Child, ChildStdin, ChildStdout, Stdio};

use serde::{Deserialize, Serialize};

use crate::comparison::pairing::RowPair;
use crate::gate::against::{AgainstError, Contest, Program, is_look};
use measurement::record::{FloorRecord, RunRecord};
use measurement::rounds::interleaved::round_order;
use measurement::system::child_process::{ChildError, ended_early, without_samples};
use measurement::system::clock::Clock;
use measurement::system::progress::Progress;
use statistics::estimate::median;
use statistics::series::Series;

/// Laps of each row in a process, as many as take [`PROCESS_SECONDS`] within these bounds; the
/// first finds neither memory nor caches, and is not counted.
const LAPS: (u32, u32) = (5, 40);
/// Seconds of a process's laps that are worth its start.
const PROCESS_SECONDS: f64 = 0.4;

#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Serialize)]
pub struct Key {
    pub scene: String,
    pub row: String,
    /// `build`, `trace`, or a kind of rays that has a threshold.
    pub quantity: &'static str,
}

impl Key {
    pub fn of(row: &RowPair<'_>, quantity: &'static str) -> Self {
        Self { scene: row.scenes[1].name.clone(), row: row.rows[1].label(), quantity }
    }
}

#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PairedTimes {
    #[serde(flatten)]
    pub key: Key,
    /// Seconds of the old program, the new one, and the new one's copy, a lap each.
    pub times: Vec<[f64; 3]>,
    pub processes: Vec<u32>,
}

impl PairedTimes {
    /// Laps, each with the process that it is of.
    pub fn turns(&self) -> impl Iterator<Item = (u32, [f64; 3])> {
        self.processes.iter().copied().zip(self.times.iter().copied())
    }
}

/// The order of the three programs in a lap.
fn order(seed: u64, row: &str, lap: u32) -> Vec<usize> {
    round_order(seed, &format!("laps/{row}"), lap as usize, 3)
}

/// Laps of each row in a process, by the time that a visit of each took.
fn laps(like: &RunRecord) -> u32 {
    let samples = like.scenes.iter().flat_map(|s| &s.rows).flat_map(|r| &r.samples);
    let seconds: f64 = samples.map(|s| s.build_s + s.total_trace_s()).sum();
    let laps = (PROCESS_SECONDS / seconds.max(1e-6)).ceil().min(f64::from(LAPS.1));
    (laps as u32).max(LAPS.0)
}

impl Contest {
    /// Build and trace times of the rows that all programs have. `undecided` says, of the laps so
    /// far, what is not decided.
    pub fn times(
        &self,
        clock: &dyn Clock,
        progress: &Progress,
        undecided: &dyn Fn(&[PairedTimes]) -> BTreeSet<Key>,
    ) -> Result<Vec<PairedTimes>, AgainstError> {
        let laps = laps(&self.like);
        let mut all: Vec<PairedTimes> = Vec::new();
        let mut like = self.like.clone();
        let (start, mut process) = (clock.now(), 0);
        while self.pace.goes_on(process, clock.now().saturating_sub(start)) {
            if is_look(process) {
                let open = undecided(&all);
                like.retain_rows(|scene, row| {
                    let label = row.label();
                    open.iter().any(|key| key.scene == scene && key.row == label)
                });
                if like.scenes.is_empty() {
                    break;
                }
            }
            for scene in &like.scenes {
                progress.message(format!("{}: process {}", scene.name, process + 1));
                let own = RunRecord { scenes: vec![scene.clone()], ..like.clone() };
                self.process(process, &own, laps, &mut all)?;
            }
            process += 1;
            progress.step(clock.now());
        }
        Ok(all)
    }

    /// A process of each program, and their laps over the rows of a scene.
    fn process(
        &self,
        process: u32,
        like: &RunRecord,
        laps: u32,
        all: &mut Vec<PairedTimes>,
    ) -> Result<(), AgainstError> {
        let Some(scene) = like.scenes.first() else { return Ok(()) };
        let mut runners: Vec<Option<Runner>> = vec![None, None, None];
        for place in order(self.pace.seed, "start", process) {
            let runner = Runner::start(&self.programs[place], &self.as_named_by(place, like));
            runners[place] = Some(runner.map_err(AgainstError::of(place))?);
        }
        let rows: Vec<String> = scene.rows.iter().map(|row| row.label()).collect();
        let old = self.as_named_by(0, like);
        let old_rows: Vec<String> =
            old.scenes.iter().flat_map(|s| &s.rows).map(|row| row.label()).collect();
        for lap in 0..=laps {
            let first = process * (laps + 1) + lap;
            for row in round_order(self.pace.seed, &scene.name, first as usize, rows.len()) {
                let mut seen: [Option<Lap>; 3] = [None, None, None];
                for place in order(self.pace.seed, &rows[row], first) {
                    let name = if place == 0 { &old_rows[row] } else { &rows[row] };
                    if let Some(runner) = &mut runners[place] {
                        seen[place] = runner.lap(name).map_err(AgainstError::of(place))?;
                    }
                }
                // the first lap finds neither memory nor caches
                if let (true, [Some(old), Some(new), Some(copy)]) = (lap > 0, seen) {
                    let (name, label) = (&scene.name, &rows[row]);
                    let key = |quantity| Key { scene: name.clone(), row: label.clone(), quantity };
                    let [a, b, c] = [&old, &new, &copy];
                    add(all, key("build"), process, [a.build_s, b.build_s, c.build_s]);
                    let traces = [a, b, c].map(|lap| lap.trace_s.values().sum());
                    add(all, key("trace"), process, traces);
                    for kind in self.thresholds.kinds_of(&rows[row]) {
                        let of_kind = [a, b, c].map(|lap| lap.trace_s.get(kind).copied());
                        if let [Some(a), Some(b), Some(c)] = of_kind {
                            add(all, key(kind), process, [a, b, c]);
                        }
                    }
                }
            }
        }
        for (place, runner) in runners.into_iter().enumerate() {
            runner.map_or(Ok(()), Runner::end).map_err(AgainstError::of(place))?;
        }
        Ok(())
    }
}

fn add(all: &mut Vec<PairedTimes>, key: Key, process: u32, seconds: [f64; 3]) {
    let known = all.iter().position(|known| known.key == key).unwrap_or_else(|| {
        all.push(PairedTimes { key, times: Vec::new(), processes: Vec::new() });
        all.len() - 1
    });
    all[known].times.push(seconds);
    all[known].processes.push(process);
}

/// How far the copy was from the new program: its ratio within laps, over the processes.
pub fn floor(pairs: &[PairedTimes]) -> Option<FloorRecord> {
    FloorRecord::of(pairs.iter().filter_map(|paired| {
        let Key { scene, row, quantity } = &paired.key;
        let quotients: Series =
            paired.turns().map(|(process, [_, new, copy])| (process, copy / new)).collect();
        let quotient = quotients.middle().or_else(|| median(quotients.values()))?;
        Some((format!("{scene}: {row}, {quantity}"), quotient))
    }))
}

/// A build of a row and a pass over its rays.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Lap {
    pub build_s: f64,
    /// Seconds of each kind of rays.
    pub trace_s: BTreeMap<String, f64>,
}

#[derive(Debug)]
pub struct Runner {
    program: PathBuf,
    child: Child,
    input: Option<ChildStdin>,
    output: BufReader<ChildStdout>,
}

impl Runner {
    /// Starts a program with the rows of a record; it gets ready while others start.
    pub fn start(program: &Program, like: &RunRecord) -> Result<Self, ChildError> {
        let mut command = program.child("laps");
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let path = program.path.clone();
        let failed = |source| ChildError::Start { program: path.clone(), source };
        let mut child = command.spawn().map_err(failed)?;
        let pipes = (child.stdin.take(), child.stdout.take());
        let (Some(input), Some(output)) = pipes else {
            return Err(failed(std::io::ErrorKind::BrokenPipe.into()));
        };
        let (input, output) = (Some(input), BufReader::new(output));
        let mut runner = Self { program: path.clone(), child, input, output };
        let text = serde_json::to_string(&without_samples(like));
        let text = text.map_err(|e| runner.unreadable(&e))?;
        runner.say(&text)?;
        Ok(runner)
    }

    /// One lap of a row; none where the row is not timed.
    pub fn lap(&mut self, row: &str) -> Result<Option<Lap>, ChildError> {
        self.say(row)?;
        let mut line = String::new();
        match self.output.read_line(&mut line) {
            Ok(n) if n > 0 => serde_json::from_str(&line).map_err(|e| self.unreadable(&e)),
            _ => Err(self.failure()),
        }
    }

    pub fn end(mut self) -> Result<(), ChildError> {
        self.input = None;
        match self.child.wait() {
            Ok(status) if status.success() => Ok(()),
            _ => Err(self.failure()),
        }
    }

    fn say(&mut self, line: &str) -> Result<(), ChildError> {
        let said =
            self.input.as_mut().map(|input| writeln!(input, "{line}").and_then(|()| input.flush()));
        match said {
            Some(Ok(())) => Ok(()),
            // its last words say more than the closed pipe
            _ => Err(self.failure()),
        }
    }

    fn unreadable(&self, error: &serde_json::Error) -> ChildError {
        ChildError::Answer { program: self.program.clone(), message: error.to_string() }
    }

    fn failure(&mut self) -> ChildError {
        self.input = None;
        let mut said = String::new();
        if let Some(mut stderr) = self.child.stderr.take() {
            let _ = stderr.read_to_string(&mut said);
        }
        match self.child.wait() {
            Ok(status) => ended_early(&self.program, status, &said),
            Err(source) => ChildError::Start { program: self.program.clone(), source },
        }
    }
}

impl Drop for Runner {
    fn drop(&mut self) {
        // one that was not asked to end is not waited for
        if self.input.take().is_some() {
            let _ = self.child.kill();
            let _ = self.child.wait();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_of_two_programs_runs_first_equally_often() {
        let orders: Vec<Vec<usize>> = (0..8).map(|lap| order(3, "bvh", lap)).collect();
        for (a, b) in [(0, 1), (0, 2), (1, 2)] {
            let first = orders.iter().filter(|order| {
                let place = |program| order.iter().position(|p| *p == program);
                place(a) < place(b)
            });
            assert_eq!(first.count(), 4);
        }
    }

    #[test]
    fn the_planted_difference_of_the_copy_is_the_floor() {
        let key = Key { scene: "tetra".into(), row: "a".into(), quantity: "trace" };
        let mut all = Vec::new();
        for process in 0..3 {
            add(&mut all, key.clone(), process, [2.0, 1.0, 1.1]);
        }
        assert_eq!(all[0].processes, [0, 1, 2]);
        let floor = floor(&all).unwrap();
        let is_named = floor.row == "tetra: a, trace";
        assert!((floor.floor - 0.1).abs() < 1e-9 && is_named, "{floor:?}");
    }
}
