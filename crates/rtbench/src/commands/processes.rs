//! The other processes of a run: each builds and times a scene again, with rounds that go on where the
//! last process ended. Every second one runs a copy of the program's file: what it differs by is the
//! floor of the run.

use std::path::PathBuf;
use std::process::Command;

use crate::context::Context;
use crate::error::Error;
use crate::gate::GateError;
use crate::gate::against::own_program;
use measurement::plan::Plan;
use measurement::record::floor::factors;
use measurement::record::{FloorRecord, RunRecord, SceneRecord};
use measurement::rounds::joined::join;
use measurement::system::child_process::{ChildError, answer, arguments, without_samples};
use measurement::system::program_copy::ProgramCopy;
use measurement::system::progress::Progress;

/// A check and a baseline have one process of the copy, with a third of their rounds.
const PART_OF_ROUNDS: usize = 3;
/// Rounds of that process, at the least.
const FEWEST_ROUNDS: usize = 5;

/// Whether that process runs the copy.
fn is_copy(process: u32) -> bool {
    process % 2 == 1
}

/// What starts them.
pub struct Processes {
    program: PathBuf,
    copy: ProgramCopy,
    allow_outside: bool,
    /// How far the copy was from the program, by row, where its samples are not kept.
    unkept: Vec<(String, f64)>,
}

impl Processes {
    /// None where the plan has a single process.
    ///
    /// # Errors
    /// [`Error`] where this program's file is not known or cannot be copied.
    pub fn of(context: &Context<'_>, plan: &Plan<'_>) -> Result<Option<Self>, Error> {
        let program = context.environment.program.as_ref();
        if plan.processes < 2 && (!plan.has_copy || program.is_none()) {
            return Ok(None);
        }
        let program = own_program(program).map_err(GateError::from)?.to_owned();
        let temporary = context.environment.temporary.clone().unwrap_or_else(std::env::temp_dir);
        let copy = ProgramCopy::of(&program, &temporary)?;
        let allow_outside = context.scenes.allows_outside();
        Ok(Some(Self { program, copy, allow_outside, unkept: Vec::new() }))
    }

    /// Measures the scene in all other processes and joins what they say to its record.
    ///
    /// # Errors
    /// [`ChildError`] of the first process that gives no answer; the samples of those before it stay.
    pub fn measure(
        &mut self,
        plan: &Plan<'_>,
        run: &RunRecord,
        scene: &mut SceneRecord,
        progress: &Progress,
    ) -> Result<(), ChildError> {
        let rounds = scene.rows.iter().map(|row| row.samples.len()).max().unwrap_or(0);
        if rounds == 0 {
            return Ok(());
        }
        if plan.processes < 2 {
            let few = rounds.div_ceil(PART_OF_ROUNDS).max(FEWEST_ROUNDS).min(rounds);
            progress.message(format!("{}: a copy of this program", scene.name));
            let other = self.one(run, scene, 1, few, rounds)?;
            let mut both = scene.clone();
            join(&mut both, other, plan.seed);
            self.unkept.extend(factors(&both, is_copy));
            return Ok(());
        }
        for process in 1..plan.processes {
            progress.message(format!(
                "{}: process {} of {}",
                scene.name,
                process + 1,
                plan.processes
            ));
            let first = rounds * process as usize;
            let other = self.one(run, scene, process, rounds, first)?;
            join(scene, other, plan.seed);
        }
        Ok(())
    }

    /// The record of one process.
    fn one(
        &self,
        run: &RunRecord,
        scene: &SceneRecord,
        process: u32,
        rounds: usize,
        first_round: usize,
    ) -> Result<SceneRecord, ChildError> {
        let mut wanted = scene.clone();
        wanted.rows.retain(|row| !row.samples.is_empty());
        let mut like = RunRecord { scenes: vec![wanted], ..run.clone() };
        if let Some(row) = scene.rows.iter().find(|row| row.is_reference) {
            like.settings.reference = row.label();
        }
        let program = if is_copy(process) { self.copy.path() } else { &self.program };
        let mut command = Command::new(program);
        command.args(arguments(self.allow_outside)).args(["measure", "--lightly"]);
        command.args(["--rounds", &rounds.to_string()]);
        command.args(["--process", &process.to_string()]);
        command.args(["--first-round", &first_round.to_string()]);
        let answered: RunRecord = answer(&mut command, &without_samples(&like))?;
        let same = answered.scenes.into_iter().find(|s| s.name == scene.name);
        same.filter(|same| same.rays == scene.rays).ok_or_else(|| ChildError::Answer {
            program: program.into(),
            message: format!("it has other rays of {}, or none", scene.name),
        })
    }

    /// How far the copy was from the program in all scenes so far.
    pub fn floor(&self, scenes: &[SceneRecord]) -> Option<FloorRecord> {
        let kept = scenes.iter().flat_map(|scene| factors(scene, is_copy));
        FloorRecord::of(kept.chain(self.unkept.iter().cloned()))
    }
}
