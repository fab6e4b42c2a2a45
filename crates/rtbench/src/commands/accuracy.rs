//! `rtbench accuracy`: what accuracy costs in time, axis by axis.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::path::Path;

use renderer::RaySettings;

use crate::args::AccuracyArgs;
use crate::context::Context;
use crate::error::{Error, FAILURE, SUCCESS};
use measurement::scenes::KnownScene;
use measurement::system::child_process::answer;
use measurement::system::files::write_text;
use measurement::system::pools::pool;
use presentation::json::FormatError;
use studies::accuracy::axes::select;
use studies::accuracy::axis::Axis;
use studies::accuracy::record::{AccuracyRecord, AxisRecord, SceneOutcome};
use studies::accuracy::stage::{Limits, PreparedScene, Stage};
use studies::accuracy::timing::join;
use studies::accuracy::{cost_tables, pictures, report, summary};
use studies::error::StudyError;

/// Pixels of the image whose rays are traced, an axis, in a full run and in a quick one.
const SIZE: (u32, u32) = (96, 32);
/// Rays of a timed pass, at most.
const TIMED_RAYS: (usize, usize) = (20_000, 3_000);
/// Trials of an exact oracle for each variant.
const TRIALS: (usize, usize) = (100_000, 10_000);
const ROUNDS: (usize, usize) = (15, 5);

/// Defaults of a full or a quick run.
fn pick<T>((full, first_look): (T, T), quick: bool) -> T {
    if quick { first_look } else { full }
}

/// Columns that stay where not all fit.
const FIRST: [&str; 3] = ["ratio [95%]", "error", "stands"];

pub fn run(context: &mut Context<'_>, args: &AccuracyArgs) -> Result<u8, Error> {
    let axes = select(&args.axes)?;
    let names = ["accuracy.json", "accuracy.csv", "accuracy.md", "summary.md"];
    let _created = context.created_folder(args.output.as_ref(), &names)?;
    let rounds = rounds(args);
    let mut record = AccuracyRecord {
        command_line: context.command_line.clone(),
        tool: context.world.tool.clone(),
        machine: (context.world.machine)(),
        compiler: context.world.compiler.clone(),
        seed: args.seed,
        quick: args.quick,
        rounds,
        processes: args.processes,
        ..AccuracyRecord::default()
    };
    let screen = context.screen();
    let start = context.clock.now();
    // of several processes this one says how wrong the variants are, and tries each
    let is_alone = args.processes == 1;
    let mut study = Study::of(context, args, if is_alone { rounds } else { 1 })?;
    for axis in axes {
        let show = |context: &mut Context<'_>, of_axis: &AxisRecord, scene: &SceneOutcome| {
            let steps = cost_tables::steps(of_axis, scene, args.seed);
            for table in [report::table(of_axis, scene)].into_iter().chain(steps) {
                screen.write_fitted(context.out, &table, &FIRST)?;
            }
            Ok(())
        };
        let mut of_axis = study.measured(context, axis, |context, of_axis, scene| {
            if is_alone { show(context, of_axis, scene) } else { Ok(()) }
        })?;
        if !is_alone {
            if let Err(error) = in_processes(context, args, &mut of_axis) {
                study.failures += 1;
                context.error(&error);
            }
            of_axis.scenes.iter().try_for_each(|scene| show(context, &of_axis, scene))?;
        }
        for table in cost_tables::over_scenes(&of_axis, args.seed) {
            screen.write_fitted(context.out, &table, &FIRST)?;
        }
        record.axes.push(of_axis);
        record.took_s = context.clock.seconds_since(start);
        if let Some(folder) = &args.output {
            write_all(folder, &record)?;
        }
    }
    if let Some(folder) = &args.output {
        pictures::write_all(folder, context.registry)?;
    }
    if let Some(table) = cost_tables::effects(&record) {
        screen.write_fitted(context.out, &table, &FIRST)?;
    }
    screen.write_notes(context.out, report::GLOSSARY)?;
    screen.write_table(context.out, &summary::advice(&record))?;
    writeln!(context.out, "The whole took {}.", report::took(record.took_s))?;
    let has_faults = record.axes.iter().flat_map(|a| &a.scenes).any(|s| !s.faults.is_empty());
    Ok(if study.failures > 0 || has_faults { FAILURE } else { SUCCESS })
}

/// Times the variants of an axis in fresh processes, one after the other.
fn in_processes(
    context: &Context<'_>,
    args: &AccuracyArgs,
    axis: &mut AxisRecord,
) -> Result<(), Error> {
    let program = context.own_program()?;
    let asked = AccuracyArgs { axes: vec![axis.axis.clone()], output: None, ..args.clone() };
    for process in 0..args.processes {
        let answered: Vec<AxisRecord> = answer(&mut program.child("accuracy"), &asked)?;
        for other in &answered {
            join(axis, other, process, args.seed)?;
        }
    }
    Ok(())
}

/// The axes, timed for the process that started this one, which says of those that a scene does not
/// serve. Trials are made anew: some axes time rays that they draw for them.
pub fn times(context: &mut Context<'_>, args: &AccuracyArgs) -> Result<Vec<AxisRecord>, Error> {
    let mut study = Study::of(context, args, rounds(args))?;
    study.limits.only_times = true;
    let axes = select(&args.axes)?.into_iter();
    let axes = axes.map(|axis| study.measured(context, axis, |_, _, _| Ok(())));
    axes.collect()
}

fn rounds(args: &AccuracyArgs) -> usize {
    args.rounds.map_or(pick(ROUNDS, args.quick), |n| n as usize)
}

/// Rays of a timed pass: as many more as the image has more pixels.
fn timed_rays(size: u32, quick: bool) -> usize {
    let share = f64::from(size) / f64::from(pick(SIZE, quick));
    (pick(TIMED_RAYS, quick) as f64 * share * share).ceil() as usize
}

struct Study {
    limits: Limits,
    size: u32,
    named: Vec<String>,
    /// Scenes by their names; each is loaded once.
    prepared: BTreeMap<String, PreparedScene>,
    /// Scenes and axes that failed.
    failures: usize,
}

impl Study {
    /// As asked for, in so many rounds.
    fn of(context: &Context<'_>, args: &AccuracyArgs, rounds: usize) -> Result<Self, Error> {
        // refused before anything is measured
        context.scenes.resolve(&args.scenes)?;
        let quick = args.quick;
        let size = args.size.unwrap_or(pick(SIZE, quick));
        Ok(Self {
            limits: Limits {
                rounds,
                timed_rays: timed_rays(size, quick),
                aims: args.trials.map_or(pick(TRIALS, quick), |n| n as usize),
                quick,
                seed: args.seed,
                only_times: false,
            },
            size,
            named: args.scenes.clone(),
            prepared: BTreeMap::new(),
            failures: 0,
        })
    }

    /// An axis on its scenes, or on those that are named; `show` is told of each.
    fn measured(
        &mut self,
        context: &mut Context<'_>,
        axis: &'static Axis,
        mut show: impl FnMut(&mut Context<'_>, &AxisRecord, &SceneOutcome) -> Result<(), Error>,
    ) -> Result<AxisRecord, Error> {
        let asked = if self.named.is_empty() {
            axis.scenes.iter().map(|s| (*s).into()).collect()
        } else {
            self.named.clone()
        };
        // builds and rays use the threads of this pool: one, so that nothing is timed beside
        // another
        let one_thread = pool(1)?;
        let (registry, occluders, clock) = (context.registry, context.occluders, context.clock);
        let mut of_axis = AxisRecord {
            axis: axis.name.into(),
            metric: axis.metric.into(),
            reference: axis.reference.into(),
            scenes: Vec::new(),
        };
        for known in context.scenes.resolve(&asked)? {
            let subjects = match self.prepared(&*known, context) {
                Ok(prepared) => axis.measure.subjects(prepared),
                Err(error) => {
                    self.failures += 1;
                    context.error(&error);
                    continue;
                }
            };
            for subject in subjects {
                let (name, limits) = (known.name(), self.limits);
                let outcome = self.prepared(&*known, context).and_then(|prepared| {
                    let stage = Stage {
                        axis: axis.name,
                        name,
                        prepared,
                        registry,
                        occluders,
                        clock,
                        limits,
                    };
                    Ok(one_thread.install(|| axis.measure.outcome(&stage, subject))?)
                });
                match outcome {
                    Ok(outcome) => {
                        show(context, &of_axis, &outcome)?;
                        of_axis.scenes.push(outcome);
                    }
                    // what a scene lacks, it lacks for all subjects
                    Err(Error::Study(error)) if matches!(*error, StudyError::UnfitScene { .. }) => {
                        context.warn(&error);
                        break;
                    }
                    Err(error) => {
                        self.failures += 1;
                        context.error(&error);
                        break;
                    }
                }
            }
        }
        Ok(of_axis)
    }

    fn prepared(
        &mut self,
        known: &dyn KnownScene,
        context: &Context<'_>,
    ) -> Result<&PreparedScene, Error> {
        let free = match self.prepared.entry(known.name().to_owned()) {
            Entry::Occupied(kept) => return Ok(kept.into_mut()),
            Entry::Vacant(free) => free,
        };
        let (resolution, seed) = ([self.size; 2], self.limits.seed);
        let settings = RaySettings { resolution, seed, ..RaySettings::default() };
        let scene = known.load()?.scene;
        Ok(free.insert(PreparedScene::new(scene, context.registry, &settings)?))
    }
}

/// Everything so far, so that a killed run keeps what it finished.
fn write_all(folder: &Path, record: &AccuracyRecord) -> Result<(), Error> {
    let write = |name: &str, text: String| write_text(&folder.join(name), &text);
    write("accuracy.csv", report::to_csv(record)?)?;
    write("accuracy.md", report::to_markdown(record))?;
    let mut page = summary::to_markdown(record);
    page.push_str(&pictures::captions());
    write("summary.md", page)?;
    write("accuracy.json", serde_json::to_string(record).map_err(FormatError::from)?)?;
    if let Some(axis) = record.axes.last() {
        write(&format!("{}.svg", axis.axis), report::to_svg(axis))?;
    }
    Ok(())
}
