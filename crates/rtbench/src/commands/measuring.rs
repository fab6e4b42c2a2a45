//! Measures all scenes of a plan, one after another; shared by all commands that measure.
//!
//! Whatever goes wrong with a scene costs that scene only. What is finished is in the journal, if
//! there is one, before anything else is done with it.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering::SeqCst};
use std::time::Duration;

use crate::commands::budget::{Budget, progress, steps_of};
use crate::commands::processes::Processes;
use crate::commands::row_deaths::{RowJournal, refuse_deadly, skip_deadly};
use crate::context::Context;
use crate::error::Error;
use crate::exit_code::{FAILURE, SUCCESS, WRONG_HITS};
use crate::exports::elsewhere;
use crate::exports::outputs::Outputs;
use crate::gate::GateError;
use crate::gate::against::AgainstError;
use measurement::journal::Journal;
use measurement::journal::lines::{DeathCounts, Line};
use measurement::plan::Plan;
use measurement::record::settings::{PROCESSOR_TIME, TIME_OF_DAY};
use measurement::record::summary::summarize;
use measurement::record::warnings;
use measurement::record::{RunRecord, SCHEMA_VERSION, SceneRecord, Settings, Verdict};
use measurement::rounds::error::MeasureError;
use measurement::rounds::scene_run::{SceneInput, run_scene};
use measurement::scenes::KnownScene;
use measurement::settings::{Lights, Precision};
use measurement::system::interrupt;
use measurement::system::panics::caught;
use measurement::system::pools::Pools;
use measurement::system::world::World;
use renderer::ShadowRays;
use studies::run::conclusions::{conclude_run, conclude_scene};
use studies::sweep::sizes::{admission, quantities};

/// Results of a plan.
#[derive(Debug)]
pub struct PlanResults {
    /// Everything about the scenes that could be measured.
    pub record: RunRecord,
    /// Scenes that could not.
    pub failures: usize,
    /// Files or folders of results were removed while it went on, and made again.
    pub disturbed: bool,
}

/// State of a run beside its outputs, including results of an earlier part.
#[derive(Debug, Default)]
pub struct RunState {
    /// Journal that finished scenes are appended to.
    pub journal: Option<Journal>,
    /// Scenes that are finished already, by their places in the plan.
    pub finished: BTreeMap<usize, SceneRecord>,
    /// How often each row ended the program.
    pub deaths: DeathCounts,
    /// Number of finished scenes, for progress display.
    pub count: Arc<AtomicUsize>,
}

impl RunState {
    fn note(&mut self, line: Line) -> Result<(), Error> {
        self.journal.as_mut().map_or(Ok(()), |journal| Ok(journal.note(&line)?))
    }

    fn append(&mut self, line: impl FnOnce() -> Line) -> Result<(), Error> {
        self.journal.as_mut().map_or(Ok(()), |journal| Ok(journal.append(&line())?))
    }

    /// Makes what was removed since again, and writes what is finished. Whether anything was.
    fn write(
        &mut self,
        outputs: &mut Outputs<'_>,
        record: &RunRecord,
        over: bool,
    ) -> Result<bool, Error> {
        let mut was_gone = outputs.restore()?;
        if let Some(journal) = &mut self.journal {
            was_gone |= journal.restore()?;
        }
        outputs.write(record, over)?;
        Ok(was_gone)
    }
}

/// [`measure_rest`] of a run that keeps nothing beside its outputs.
///
/// # Errors
/// Those of [`measure_rest`].
pub fn measure_scenes(
    context: &mut Context<'_>,
    plan: &Plan<'_>,
    outputs: &mut Outputs<'_>,
    show: impl FnMut(&mut Context<'_>, &RunRecord, &SceneRecord) -> Result<(), Error>,
) -> Result<PlanResults, Error> {
    let record = begin(context.world, &context.command_line, plan);
    measure_rest(context, plan, outputs, RunState::default(), record, show)
}

/// Measures the scenes of the plan that are not finished. After each, the outputs are written anew
/// and `show` prints it; finished ones are shown in their place.
///
/// # Errors
/// [`Error`] for threads that cannot be started, outputs that cannot be written, and those of
/// `show`. A scene that fails is reported and costs the others nothing.
pub fn measure_rest(
    context: &mut Context<'_>,
    plan: &Plan<'_>,
    outputs: &mut Outputs<'_>,
    mut kept: RunState,
    mut record: RunRecord,
    mut show: impl FnMut(&mut Context<'_>, &RunRecord, &SceneRecord) -> Result<(), Error>,
) -> Result<PlanResults, Error> {
    outputs.write(&record, false)?;
    let mut processes = Processes::of(context, plan)?;
    let pools = Pools::new(plan.threads)?;
    let unfinished = (0..plan.scenes.len()).filter(|i| !kept.finished.contains_key(i));
    let progress = progress(context, plan, unfinished.map(|i| steps_of(plan, i)).sum());
    let budget = Budget::new(plan, context.clock.now(), kept.finished.len());
    let (mut failures, mut disturbed, mut is_summed_up) = (0_usize, false, true);
    let mut steps = 0;
    let mut left = plan.scenes.len() - kept.finished.len();
    for (i, known) in plan.scenes.iter().enumerate() {
        let finished_before = kept.finished.remove(&i);
        let is_new = finished_before.is_none();
        let measured = match finished_before {
            Some(scene) => Ok(scene),
            None => {
                kept.note(Line::Scene(i))?;
                progress.message(format!("{}: loading", known.name()));
                let deadline = budget.deadline(context.clock.now(), left);
                left -= 1;
                steps += steps_of(plan, i);
                let log = RowJournal::new(kept.journal.as_mut());
                let mut equipment = SceneInput {
                    pools: &pools,
                    clock: context.clock,
                    world: context.world,
                    progress: &progress,
                    trials: &[],
                    log: &log,
                    laps: None,
                };
                let own = plan.of_scene(i);
                let own = own.as_ref().unwrap_or(plan);
                let mut trials = admission::trials(plan, &record.scenes, known.name(), &equipment);
                skip_deadly(&mut trials, own, i, &kept.deaths);
                equipment.trials = &trials;
                match admission::without_rows(plan, &record, known.name(), &trials) {
                    Some(scene) => Ok(scene),
                    None => refuse_deadly(known.name(), i, &kept.deaths)
                        .and_then(|()| measure_one(own, &**known, &equipment, deadline)),
                }
            }
        };
        let scene = match measured {
            Ok(mut scene) => {
                let others = processes.as_mut().filter(|_| is_new && !interrupt::is_stopping());
                let joined = others.map_or(Ok(()), |processes| {
                    let own = plan.of_scene(i);
                    let own = own.as_ref().unwrap_or(plan);
                    let share = budget.share(context.clock.now(), left + 1);
                    processes.measure(own, &record, &mut scene, share, &progress)
                });
                if let Err(error) = joined {
                    // a floor that is missing costs nothing but itself
                    failures += usize::from(plan.processes > 1);
                    let error = GateError::from(AgainstError::New(error));
                    progress.suspend(|| match plan.processes {
                        1 => context.warn(&error),
                        _ => context.error(Error::from(error)),
                    });
                }
                if is_new {
                    conclude_scene(&mut scene, plan.seed);
                }
                scene
            }
            Err(error) => {
                // One bad scene does not cost the others.
                failures += 1;
                kept.append(|| Line::Failed { scene: i, error: error.to_string() })?;
                progress.reach(steps);
                progress.suspend(|| context.error(&error));
                continue;
            }
        };
        progress.reach(steps);
        let mut kept_well = Ok(false);
        if is_new {
            let finished = || Line::Finished { scene: i, record: Box::new(scene.clone()) };
            let appended = kept.append(finished);
            kept.count.fetch_add(1, SeqCst);
            record.scenes.push(scene);
            record.peak_rss_bytes = context.world.peak_rss().max(record.peak_rss_bytes);
            is_summed_up = kept.journal.is_none() || is_due(record.scenes.len());
            if is_summed_up {
                sum_up(&mut record);
                kept_well = appended.and_then(|()| kept.write(outputs, &record, false));
            } else {
                kept_well = appended.map(|()| false);
            }
        } else {
            // what was finished before is written once, with the next scene or at the end
            record.scenes.push(scene);
            is_summed_up = false;
        }
        if let Some(scene) = record.scenes.last() {
            // What the disk does not take is shown at least.
            progress.suspend(|| show(context, &record, scene))?;
        }
        disturbed |= progress.suspend(|| saved(context, kept_well, outputs, &record))?;
        interrupt::end_if_stopping();
    }
    progress.finish();
    if !is_summed_up {
        sum_up(&mut record);
    }
    record.complete = true;
    record.floor = processes.and_then(|processes| processes.floor(&record.scenes));
    record.load[1] = context.world.load();
    record.warnings = warnings::of(&record);
    let kept_well =
        kept.append(|| Line::Complete).and_then(|()| kept.write(outputs, &record, true));
    disturbed |= saved(context, kept_well, outputs, &record)?;
    for warning in record.warnings.iter().filter(|_| !plan.is_untimed) {
        context.warn(warning);
    }
    outputs.print(&record, context.out)?;
    Ok(PlanResults { record, failures, disturbed })
}

/// Returns whether results are written with so many scenes. What the journal has is not lost: they
/// are written with each of the first scenes, then ever less often, so that a run of many does not
/// write all of them each time.
fn is_due(scenes: usize) -> bool {
    scenes < 64 || scenes.is_multiple_of(scenes / 32)
}

/// Updates the summary over all scenes so far.
fn sum_up(record: &mut RunRecord) {
    record.summary = summarize(&record.scenes, &record.settings);
    // the sizes of one scene are no scenes to take means over
    if record.scale.is_none() {
        conclude_run(record);
    }
    if let Some(scale) = &mut record.scale {
        scale.slopes = quantities::slopes(&record.scenes);
    }
}

/// Says where results had to be made again. Those that cannot be written where they belong are
/// written elsewhere, and printed where that fails, too.
fn saved(
    context: &mut Context<'_>,
    kept_well: Result<bool, Error>,
    outputs: &Outputs<'_>,
    record: &RunRecord,
) -> Result<bool, Error> {
    let error = match kept_well {
        Ok(was_gone) => {
            if was_gone {
                context.warn(
                    "files of results were removed while the run went on: they are made again, with \
                     all that was measured",
                );
            }
            return Ok(was_gone);
        }
        Err(error) => error,
    };
    if outputs.are_files() && !record.scenes.is_empty() {
        let scenes = record.scenes.len();
        match elsewhere::keep(context.environment.temporary.as_deref(), record) {
            Ok(path) => context.error(format_args!(
                "what is measured so far, {scenes} scene(s), is kept in {}",
                path.display()
            )),
            Err(why) => {
                outputs.print(record, context.out)?;
                context.error(format_args!(
                    "what is measured so far, {scenes} scene(s), is printed and nowhere else: {why}"
                ));
            }
        }
    }
    Err(error)
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
    } else if measured.failures > 0
        || measured.disturbed
        || rows().any(|r| r.verdict == Verdict::Panicked)
        || rows().any(|r| r.verdict == Verdict::OutOfMemory)
        || rows().any(|r| r.verdict == Verdict::NotBuilt && r.known_defect.is_none())
    {
        FAILURE
    } else {
        SUCCESS
    }
}

/// Says what went wrong in a scene.
pub fn warn_of(context: &mut Context<'_>, scene: &SceneRecord) {
    for warning in &scene.warnings {
        context.warn(format_args!("{}: {warning}", scene.name));
    }
    for refused in &scene.oracle.refused {
        context.warn(format_args!("{}: not asked first: {refused}", scene.name));
    }
}

/// The record before the first scene.
pub fn begin(world: &dyn World, command_line: &[String], plan: &Plan<'_>) -> RunRecord {
    RunRecord {
        schema_version: SCHEMA_VERSION,
        tool: world.tool(),
        command_line: command_line.to_vec(),
        started_unix_s: world.unix_seconds(),
        machine: world.machine(),
        compiler: world.compiler(),
        settings: Settings {
            seed: plan.seed,
            threads: plan.threads,
            precision: match plan.precision {
                Precision::F32 => "f32".into(),
                Precision::F64 => "f64".into(),
            },
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
            view: plan.scenes.first().map(|s| s.view()).unwrap_or_default(),
            by_kind: plan.by_kind,
            processes: plan.processes,
            timed_by: match plan.threads {
                1 if cfg!(unix) => PROCESSOR_TIME.into(),
                _ => TIME_OF_DAY.into(),
            },
        },
        scenes: Vec::new(),
        summary: Vec::new(),
        conclusions: Vec::new(),
        peak_rss_bytes: world.peak_rss(),
        planned: plan.scenes.iter().map(|scene| scene.name().to_owned()).collect(),
        complete: false,
        load: [world.load(); 2],
        warnings: Vec::new(),
        shard: plan.part.as_ref().map(|part| part.record.clone()),
        parts: Vec::new(),
        floor: None,
        scale: None,
    }
}
