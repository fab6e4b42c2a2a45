//! The processes of a run that has several: each builds and times a scene, with rounds that go on
//! where the last process ended. Every second one runs a copy of the program's file: what it
//! differs by is the floor of the run.

use std::time::Duration;

use crate::context::Context;
use crate::error::Error;
use crate::gate::against::Program;
use measurement::plan::Plan;
use measurement::record::processes::{factors, join};
use measurement::record::{FloorRecord, RunRecord, SceneRecord};
use measurement::system::child_process::{ChildError, ProgramCopy, answer, without_samples};
use measurement::system::progress::Progress;

/// A check and a baseline have one process of the program and one of the copy, each with a third of
/// their rounds.
const PART_OF_ROUNDS: usize = 3;
/// Rounds of those processes, at the least.
const FEWEST_ROUNDS: usize = 5;
/// Most rounds of a process within a time budget.
const MOST_ROUNDS: usize = 10_000;

fn is_copy(process: u32) -> bool {
    process % 2 == 1
}

pub struct Processes {
    program: Program,
    copy: Program,
    /// The file of the copy, until all have ended.
    _file: ProgramCopy,
    /// Difference of the copy from the program, by row, if its samples are not kept.
    unkept: Vec<(String, f64)>,
}

impl Processes {
    /// None where the plan has a single process.
    pub fn of(context: &Context<'_>, plan: &Plan<'_>) -> Result<Option<Self>, Error> {
        let has_program = context.environment.program.is_some();
        if plan.processes < 2 && !(plan.has_copy && has_program) {
            return Ok(None);
        }
        let program = context.own_program()?;
        let file = context.environment.copy_of(&program.path)?;
        let copy = Program { path: file.path().to_owned(), ..program.clone() };
        Ok(Some(Self { program, copy, _file: file, unkept: Vec::new() }))
    }

    /// Builds and times the scene in fresh processes and takes what they say for the scene's times;
    /// where the plan has one process, its own, that keeps its times, and others say how far a copy
    /// is from the program. What this process did before (other scenes, all answers) is in no
    /// other: builds take up to a third less in one whose allocator has kept memory, so that only
    /// fresh processes are compared with one another.
    pub fn measure(
        &mut self,
        plan: &Plan<'_>,
        run: &RunRecord,
        scene: &mut SceneRecord,
        share: Option<Duration>,
        progress: &Progress,
    ) -> Result<(), ChildError> {
        let own_rounds = scene.rows.iter().map(|row| row.samples.len()).max().unwrap_or(0);
        if own_rounds == 0 {
            return Ok(());
        }
        let is_kept = plan.processes > 1;
        let (processes, rounds) = if is_kept {
            (plan.processes, rounds_of(plan, scene, share))
        } else {
            (2, own_rounds.div_ceil(PART_OF_ROUNDS).max(FEWEST_ROUNDS).min(own_rounds))
        };
        let mut fresh = scene.clone();
        fresh.rows.iter_mut().for_each(|row| row.samples.clear());
        let mut ended = Ok(());
        for process in 0..processes {
            let (number, name) = (process + 1, &scene.name);
            progress.message(format!("{name}: process {number} of {processes}"));
            match self.measure_in_process(run, scene, process, rounds) {
                Ok(other) => join(&mut fresh, other, plan.seed),
                Err(error) => {
                    ended = Err(error);
                    break;
                }
            }
        }
        if !is_kept {
            self.unkept.extend(factors(&fresh, is_copy));
            return ended;
        }
        for (row, fresh) in scene.rows.iter_mut().zip(fresh.rows) {
            // one that no other process has keeps the round of this one
            if !fresh.samples.is_empty() || fresh.verdict != row.verdict {
                *row = fresh;
            }
        }
        ended
    }

    fn measure_in_process(
        &self,
        run: &RunRecord,
        scene: &SceneRecord,
        process: u32,
        rounds: usize,
    ) -> Result<SceneRecord, ChildError> {
        let mut wanted = scene.clone();
        wanted.rows.retain(|row| !row.samples.is_empty());
        let mut like = RunRecord { scenes: vec![wanted], ..run.clone() };
        if let Some(row) = scene.rows.iter().find(|row| row.is_reference) {
            like.settings.reference = row.label();
        }
        let program = if is_copy(process) { &self.copy } else { &self.program };
        let mut command = program.child("measure");
        command.arg("--lightly");
        command.args(["--rounds", &rounds.to_string()]);
        command.args(["--process", &process.to_string()]);
        command.args(["--first-round", &(rounds * process as usize).to_string()]);
        let answered: RunRecord = answer(&mut command, &without_samples(&like))?;
        let same = answered.scenes.into_iter().find(|s| s.name == scene.name);
        same.filter(|same| same.rays == scene.rays).ok_or_else(|| ChildError::Answer {
            program: program.path.clone(),
            message: format!("its rays differ for {}, or are missing", scene.name),
        })
    }

    /// Difference of the copy from the program in all scenes so far.
    pub fn floor(&self, scenes: &[SceneRecord]) -> Option<FloorRecord> {
        let kept = scenes.iter().flat_map(|scene| factors(scene, is_copy));
        FloorRecord::of(kept.chain(self.unkept.iter().cloned()))
    }
}

/// Rounds of each process: as many as are asked for, or as the scene's share of a time budget has
/// room for by the round that this process made.
fn rounds_of(plan: &Plan<'_>, scene: &SceneRecord, share: Option<Duration>) -> usize {
    let at_least = plan.rounds.at_least();
    if plan.rounds.budget().is_none() {
        return at_least;
    }
    let rows = || scene.rows.iter().flat_map(|row| &row.samples);
    let round_s: f64 = rows().map(|sample| sample.build_s + sample.total_trace_s()).sum();
    let each = share.unwrap_or_default().as_secs_f64() / f64::from(plan.processes);
    ((each / round_s.max(1e-6)) as usize).clamp(at_least, MOST_ROUNDS)
}
