//! Measures all scenes of a plan, one after another; shared by all commands that measure.
//!
//! Whatever goes wrong with a scene costs that scene only. What is finished is in the journal, if
//! there is one, before anything else is done with it.

use std::io::{self, Write};
use std::sync::atomic::Ordering::SeqCst;
use std::time::Duration;

use crate::commands::processes::Processes;
use crate::commands::run_state::{
    Budget, RowJournal, RunState, is_due, refuse_deadly, skip_deadly, steps_of, sum_up,
};
use crate::context::Context;
use crate::error::{Error, FAILURE, SUCCESS, WRONG_HITS};
use crate::outputs::{Outputs, keep_elsewhere};
use measurement::journal::lines::Line;
use measurement::plan::Plan;
use measurement::record::settings::{PROCESSOR_TIME, TIME_OF_DAY};
use measurement::record::warnings;
use measurement::record::{RunRecord, SCHEMA_VERSION, SceneRecord, Settings, Verdict};
use measurement::rounds::MeasureError;
use measurement::rounds::scene_run::{SceneInput, run_scene};
use measurement::scenes::KnownScene;
use measurement::settings::{Lights, Precision};
use measurement::system::interrupt;
use measurement::system::panics::caught;
use measurement::system::pools::Pools;
use measurement::system::progress::Progress;
use measurement::system::world::World;
use renderer::ShadowRays;
use studies::run::conclusions::conclude_scene;
use studies::sweep::sizes;

#[derive(Debug)]
pub struct PlanResults {
    /// Everything about the scenes that could be measured.
    pub record: RunRecord,
    /// Why others could not.
    pub failures: Vec<Error>,
    /// Files or folders of results were removed while it went on, and made again.
    pub disturbed: bool,
}

/// [`measure_rest`] of a run that keeps nothing beside its outputs.
pub fn measure_scenes(
    context: &mut Context<'_>,
    plan: &Plan<'_>,
    outputs: Outputs<'_>,
    show: impl FnMut(&mut dyn Write, &RunRecord, &SceneRecord) -> io::Result<()>,
) -> Result<PlanResults, Error> {
    let record = begin(context.world, &context.command_line, plan);
    measure_rest(context, plan, outputs, RunState::default(), record, show)
}

/// [`measure_scenes`] that prints no tables.
pub fn measure_quietly(
    context: &mut Context<'_>,
    plan: &Plan<'_>,
    outputs: Outputs<'_>,
) -> Result<PlanResults, Error> {
    measure_scenes(context, plan, outputs, |_, _, _| Ok(()))
}

/// Measures the scenes of the plan that are not finished. After each, the outputs are written anew,
/// its warnings are printed and `show` prints it; finished ones are shown in their place.
pub fn measure_rest(
    context: &mut Context<'_>,
    plan: &Plan<'_>,
    mut outputs: Outputs<'_>,
    kept: RunState,
    record: RunRecord,
    mut show: impl FnMut(&mut dyn Write, &RunRecord, &SceneRecord) -> io::Result<()>,
) -> Result<PlanResults, Error> {
    outputs.write(&record, false)?;
    let mut run = RunInProgress::new(context, plan, outputs, kept, record)?;
    for (i, known) in plan.scenes.iter().enumerate() {
        let kept_well = match run.kept.finished.remove(&i) {
            Some(scene) => {
                // finished before: it is written with the next scene, or at the end
                run.record.scenes.push(scene);
                run.is_summed_up = false;
                Ok(false)
            }
            None => match run.measure(i, &**known)? {
                Ok(scene) => run.keep(i, scene),
                // One bad scene does not cost the others.
                Err(error) => {
                    run.keep_failure(i, error)?;
                    continue;
                }
            },
        };
        run.progress.reach(run.steps);
        if let Some(scene) = run.record.scenes.last() {
            // What the disk does not take is shown at least.
            run.progress.suspend(|| {
                warn_of(run.context, scene);
                show(run.context.out, &run.record, scene)?;
                run.context.out.flush()
            })?;
        }
        run.save_elsewhere(kept_well)?;
        interrupt::end_if_stopping();
    }
    run.finish()
}

/// The scenes of a plan while they are measured.
struct RunInProgress<'a, 'c> {
    context: &'a mut Context<'c>,
    plan: &'a Plan<'a>,
    outputs: Outputs<'a>,
    pools: Pools,
    processes: Option<Processes>,
    budget: Budget,
    progress: Progress,
    /// Steps of the progress bar when the scene is done.
    steps: u64,
    /// Scenes that are not begun.
    left: usize,
    kept: RunState,
    record: RunRecord,
    /// The summary of the record is over all of its scenes.
    is_summed_up: bool,
    failures: Vec<Error>,
    disturbed: bool,
}

impl<'a, 'c> RunInProgress<'a, 'c> {
    fn new(
        context: &'a mut Context<'c>,
        plan: &'a Plan<'a>,
        outputs: Outputs<'a>,
        kept: RunState,
        record: RunRecord,
    ) -> Result<Self, Error> {
        let unfinished = (0..plan.scenes.len()).filter(|i| !kept.finished.contains_key(i));
        let steps = unfinished.map(|i| steps_of(plan, i)).sum();
        Ok(Self {
            plan,
            outputs,
            pools: Pools::new(plan.threads)?,
            processes: Processes::of(context, plan)?,
            budget: Budget::new(plan, context.clock.now(), kept.finished.len()),
            progress: Progress::new(context.shows_progress(), steps, plan.rounds.budget()),
            steps: 0,
            left: plan.scenes.len() - kept.finished.len(),
            kept,
            record,
            is_summed_up: true,
            failures: Vec::new(),
            disturbed: false,
            context,
        })
    }

    /// Measures a scene, or says what is wrong with it; its rounds end within its share of a time
    /// budget.
    fn measure(
        &mut self,
        i: usize,
        known: &dyn KnownScene,
    ) -> Result<Result<SceneRecord, Error>, Error> {
        if let Some(journal) = &mut self.kept.journal {
            journal.note(&Line::Scene(i))?;
        }
        self.progress.message(format!("{}: loading", known.name()));
        let deadline = self.budget.deadline(self.context.clock.now(), self.left);
        self.left -= 1;
        self.steps += steps_of(self.plan, i);
        Ok(self.measured(i, known, deadline))
    }

    fn measured(
        &mut self,
        i: usize,
        known: &dyn KnownScene,
        deadline: Option<Duration>,
    ) -> Result<SceneRecord, Error> {
        let (plan, name) = (self.plan, known.name());
        let own = plan.of_scene(i);
        let own = own.as_ref().unwrap_or(plan);
        let log = RowJournal::new(self.kept.journal.as_mut());
        let mut equipment = SceneInput {
            pools: &self.pools,
            clock: self.context.clock,
            world: self.context.world,
            progress: &self.progress,
            trials: &[],
            log: &log,
            laps: None,
        };
        let mut trials = sizes::trials(plan, &self.record.scenes, name, &equipment);
        skip_deadly(&mut trials, own, i, &self.kept.deaths);
        equipment.trials = &trials;
        let mut scene = match sizes::without_rows(plan, &self.record, name, &trials) {
            Some(scene) => scene,
            None => {
                refuse_deadly(name, i, &self.kept.deaths)?;
                measure_one(own, known, &equipment, deadline)?
            }
        };
        self.measure_in_processes(own, &mut scene);
        conclude_scene(&mut scene, plan.seed);
        Ok(scene)
    }

    /// Measures a scene in the other processes of the run, if it has any.
    fn measure_in_processes(&mut self, own: &Plan<'_>, scene: &mut SceneRecord) {
        let Some(processes) = self.processes.as_mut().filter(|_| !interrupt::is_stopping()) else {
            return;
        };
        let share = self.budget.share(self.context.clock.now(), self.left + 1);
        let joined = processes.measure(own, &self.record, scene, share, &self.progress);
        let Err(error) = joined else { return };
        self.progress.suspend(|| match own.processes {
            1 => self.context.warn(&error),
            _ => self.context.error(&error),
        });
        // a missing A/A floor is not fatal
        if own.processes > 1 {
            self.failures.push(error.into());
        }
    }

    /// Keeps a scene in the journal, in the record and in the outputs. Returns whether results had
    /// been removed.
    fn keep(&mut self, i: usize, scene: SceneRecord) -> Result<bool, Error> {
        let finished = || Line::Finished { scene: i, record: Box::new(scene.clone()) };
        let appended = self.kept.append(finished);
        self.kept.count.fetch_add(1, SeqCst);
        let record = &mut self.record;
        record.scenes.push(scene);
        record.peak_rss_bytes = (self.context.world.peak_rss)().max(record.peak_rss_bytes);
        self.is_summed_up = self.kept.journal.is_none() || is_due(record.scenes.len());
        if !self.is_summed_up {
            return appended.map(|()| false);
        }
        sum_up(record);
        appended.and_then(|()| self.write(false))
    }

    fn keep_failure(&mut self, scene: usize, error: Error) -> Result<(), Error> {
        self.kept.append(|| Line::Failed { scene, error: error.to_string() })?;
        self.progress.reach(self.steps);
        self.progress.suspend(|| self.context.error(&error));
        self.failures.push(error);
        Ok(())
    }

    /// Makes what was removed since again, and writes what is finished. Whether anything was.
    fn write(&mut self, over: bool) -> Result<bool, Error> {
        let mut was_gone = self.outputs.restore()?;
        if let Some(journal) = &mut self.kept.journal {
            was_gone |= journal.restore()?;
        }
        self.outputs.write(&self.record, over)?;
        Ok(was_gone)
    }

    /// Says where results had to be made again. Those that cannot be written where they belong are
    /// written elsewhere, and printed where that fails, too.
    fn save_elsewhere(&mut self, kept_well: Result<bool, Error>) -> Result<(), Error> {
        let (context, scenes) = (&mut *self.context, self.record.scenes.len());
        self.progress.suspend(|| {
            if let Ok(true) = kept_well {
                context.warn(
                    "result files were removed during the run; they are written again with all \
                     results",
                );
            }
            if kept_well.is_err() && self.outputs.are_files() && scenes > 0 {
                let temporary = context.environment.temporary.as_deref();
                let what = match keep_elsewhere(temporary, &self.record) {
                    Ok(path) => format!("saved in {}", path.display()),
                    Err(why) => format!("only printed: {why}"),
                };
                context.error(format_args!("results so far ({scenes} scene(s)) are {what}"));
            }
        });
        self.disturbed |= kept_well?;
        Ok(())
    }

    fn finish(mut self) -> Result<PlanResults, Error> {
        self.progress.finish();
        let record = &mut self.record;
        if !self.is_summed_up {
            sum_up(record);
        }
        record.complete = true;
        record.floor = self.processes.take().and_then(|own| own.floor(&record.scenes));
        record.load[1] = (self.context.world.load)();
        record.warnings = warnings::of(record);
        let appended = self.kept.append(|| Line::Complete);
        let kept_well = appended.and_then(|()| self.write(true));
        self.save_elsewhere(kept_well)?;
        for warning in self.record.warnings.iter().filter(|_| !self.plan.is_untimed) {
            self.context.warn(warning);
        }
        let Self { record, failures, disturbed, .. } = self;
        Ok(PlanResults { record, failures, disturbed })
    }
}

/// Loads and measures a scene; a panic is its failure.
pub fn measure_one(
    plan: &Plan<'_>,
    known: &dyn KnownScene,
    equipment: &SceneInput<'_>,
    deadline: Option<Duration>,
) -> Result<SceneRecord, Error> {
    let measured = caught(|| {
        let loaded = known.load()?;
        Ok(match plan.precision {
            Precision::F32 => run_scene::<f32>(plan, &loaded, equipment, deadline)?,
            Precision::F64 => run_scene::<f64>(plan, &loaded, equipment, deadline)?,
        })
    });
    measured.unwrap_or_else(|source| {
        Err(MeasureError::Panicked { scene: known.name().to_owned(), source }.into())
    })
}

/// 4 when a row is wrong, 1 when something could not be measured or kept where it belongs, else 0.
pub fn exit_code(measured: &PlanResults) -> u8 {
    let rows = || measured.record.scenes.iter().flat_map(|s| &s.rows);
    if rows().any(|r| r.verdict == Verdict::Wrong) {
        WRONG_HITS
    } else if !measured.failures.is_empty()
        || measured.disturbed
        || rows().any(|r| matches!(r.verdict, Verdict::Panicked | Verdict::OutOfMemory))
        || rows().any(|r| r.verdict == Verdict::NotBuilt && r.known_defect.is_none())
    {
        FAILURE
    } else {
        SUCCESS
    }
}

pub fn warn_of(context: &mut Context<'_>, scene: &SceneRecord) {
    for warning in &scene.warnings {
        context.warn(format_args!("{}: {warning}", scene.name));
    }
    for refused in &scene.oracle.refused {
        context.warn(format_args!("{}: not asked first: {refused}", scene.name));
    }
}

pub fn begin(world: &World, command_line: &[String], plan: &Plan<'_>) -> RunRecord {
    RunRecord {
        schema_version: SCHEMA_VERSION,
        tool: world.tool.clone(),
        command_line: command_line.to_vec(),
        started_unix_s: (world.unix_seconds)(),
        machine: (world.machine)(),
        compiler: world.compiler.clone(),
        settings: Settings {
            seed: plan.seed,
            threads: plan.threads,
            precision: plan.precision.name().into(),
            resolution: plan.settings.resolution,
            max_depth: plan.settings.max_depth,
            rays: plan.kinds.iter().map(|k| k.name().to_owned()).collect(),
            reference: plan.rows.get(plan.baseline).map(|r| r.label()).unwrap_or_default(),
            quick: plan.quick,
            order: plan.orders.name().into(),
            lights: match plan.settings.shadows {
                ShadowRays::EachLight => Lights::Each.name().into(),
                ShadowRays::FirstLight => Lights::First.name().into(),
            },
            // all scenes of a plan have the same
            view: plan.scenes.first().map(|s| s.known().view.clone()).unwrap_or_default(),
            by_kind: plan.by_kind,
            processes: plan.processes,
            timed_by: match plan.threads {
                1 if cfg!(unix) => PROCESSOR_TIME.into(),
                _ => TIME_OF_DAY.into(),
            },
        },
        peak_rss_bytes: (world.peak_rss)(),
        planned: plan.scenes.iter().map(|scene| scene.name().to_owned()).collect(),
        load: [(world.load)(); 2],
        shard: plan.part.as_ref().map(|part| part.record.clone()),
        ..RunRecord::default()
    }
}
