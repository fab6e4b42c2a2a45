//! `rtbench baseline`: keep results to check against.

use std::path::Path;

use crate::args::{BaselineAction, BaselineArgs, SaveArgs};
use crate::baselines::{Baseline, BaselineError, Store, read};
use crate::commands::measuring::{exit_code, measure_quietly};
use crate::commands::run::plan_of;
use crate::commands::run_outputs;
use crate::context::Context;
use crate::error::{Error, SUCCESS};
use crate::gate::ROUNDS;
use measurement::callgrind::{self, CallgrindError, Counts};
use measurement::record::{RunRecord, label};
use measurement::system::machine::PressureWatch;
use presentation::table::words;
use presentation::text::Screen;
use studies::run::conclusions::conclude;
use studies::run::output;
use studies::run::view::View;

pub fn run(context: &mut Context<'_>, args: &BaselineArgs) -> Result<u8, Error> {
    let store = Store::new(args.folder.baselines.as_ref(), &context.environment);
    let screen = context.screen();
    match &args.action {
        BaselineAction::Save(args) => return save(context, args, &store),
        BaselineAction::List => list(context, &store, screen)?,
        BaselineAction::Show { name, tables } => {
            show(context, &store, name, &tables.view(context.screen()))?;
        }
        BaselineAction::Promote { name, to } => {
            let baseline = read(&store.existing(name)?)?;
            let path = store.save(to, &baseline, true)?;
            context.wrote(&path, format_args!("baseline {to}, a copy of {name}"));
        }
        BaselineAction::Remove { name } => store.remove(name)?,
    }
    Ok(SUCCESS)
}

fn save(context: &mut Context<'_>, args: &SaveArgs, store: &Store) -> Result<u8, Error> {
    // what makes no sense is said before anything is measured
    store.free(&args.name, context.overwrite)?;
    if args.run.resume.is_some() {
        return Err(BaselineError::Resume.into());
    }
    if args.instructions {
        callgrind::version()?;
    }
    let (mut baseline, code) = match &args.from {
        Some(path) => (finished(path)?, SUCCESS),
        None => measured(context, args)?,
    };
    if code != SUCCESS {
        context.warn(format_args!("baseline {} not saved: the run failed", args.name));
        return Ok(code);
    }
    if args.instructions {
        if let Some(path) = &args.from {
            same_program(context, path, &baseline.record)?;
        }
        baseline.instructions = Some(counted(context, &baseline.record)?);
    }
    let path = store.save(&args.name, &baseline, context.overwrite)?;
    let rows: usize = baseline.record.scenes.iter().map(|scene| scene.rows.len()).sum();
    context.wrote(&path, format_args!("baseline {}, {rows} rows", args.name));
    Ok(SUCCESS)
}

/// The results of an earlier run.
fn finished(path: &Path) -> Result<Baseline, Error> {
    let baseline = read(path)?;
    let error = || BaselineError::Incomplete(path.to_owned());
    if baseline.record.complete { Ok(baseline) } else { Err(error().into()) }
}

fn measured(context: &mut Context<'_>, args: &SaveArgs) -> Result<(Baseline, u8), Error> {
    let mut settings = args.run.settings();
    if settings.measuring.time_budget.is_none() {
        settings.measuring.rounds.get_or_insert(ROUNDS);
    }
    let mut plan = plan_of(context, &settings)?;
    plan.has_copy = true;
    run_outputs::refuse_unselected(&args.run.exports, || run_outputs::series_of(&plan))?;
    run_outputs::refuse_occupied(context, &args.run.exports, None)?;
    let outputs = run_outputs::of_run(&args.run.exports)?;
    let watch = PressureWatch::begin(context.environment.cpu_pressure.as_deref());
    let measured = measure_quietly(context, &plan, outputs)?;
    if let Some(floor) = &measured.record.floor {
        context.say(floor.in_words());
    }
    let code = exit_code(&measured);
    let cpu_pressure = watch.share();
    Ok((Baseline { record: measured.record, instructions: None, cpu_pressure }, code))
}

/// Refuses results of another commit: instructions of this one say nothing of it.
fn same_program(context: &Context<'_>, path: &Path, record: &RunRecord) -> Result<(), Error> {
    let (was, is) = (record.tool.git_revision.clone(), context.world.tool.git_revision.clone());
    if was.is_some() && was == is {
        Ok(())
    } else {
        let path = path.to_owned();
        Err(CallgrindError::OtherProgram { path, was, is }.into())
    }
}

/// Instruction counts of the rows of a record, by this program.
pub(super) fn counted(
    context: &mut Context<'_>,
    record: &RunRecord,
) -> Result<Counts, CallgrindError> {
    context.say("counting instructions under valgrind");
    let program = context.environment.program.as_deref();
    callgrind::count(program, record, context.scenes.allows_outside())
}

fn list(context: &mut Context<'_>, store: &Store, screen: Screen) -> Result<(), Error> {
    let header = vec!["baseline", "scenes", "rows", "rounds", "instructions", "commit"];
    let mut lines = Vec::new();
    for name in store.names()? {
        let Baseline { record, instructions, .. } = read(&store.existing(&name)?)?;
        let rows = record.scenes.iter().map(|s| s.rows.len()).max().unwrap_or(0);
        let commit = record.tool.git_revision.as_deref().and_then(|r| r.get(..12));
        lines.push(vec![
            name,
            record.scenes.len().to_string(),
            rows.to_string(),
            rounds(&record).to_string(),
            if instructions.is_some() { "counted" } else { "-" }.to_owned(),
            commit.unwrap_or("-").to_owned(),
        ]);
    }
    Ok(screen.write_table(context.out, &words("Baselines", header, lines))?)
}

/// Rounds of a record: the samples of its most visited row.
pub(super) fn rounds(record: &RunRecord) -> usize {
    let rows = record.scenes.iter().flat_map(|s| &s.rows);
    rows.map(|row| row.samples.len()).max().unwrap_or(0)
}

fn show(context: &mut Context<'_>, store: &Store, name: &str, view: &View) -> Result<(), Error> {
    let Baseline { mut record, instructions, .. } = read(&store.existing(name)?)?;
    // those from before conclusions have none
    conclude(&mut record);
    for scene in &record.scenes {
        output::write_scene(context.out, &record, scene, view)?;
    }
    output::write_end(context.out, &record, view)?;
    if let Some(counts) = instructions {
        let header = vec!["row", "rays", "build", "trace"];
        let title = format!("Instructions ({})", counts.valgrind);
        let number = |n: Option<u64>| n.map_or_else(|| "-".to_owned(), |n| n.to_string());
        let rows = counts.rows.iter().map(|row| {
            vec![
                format!("{}: {}", row.scene, label(&row.structure, &row.settings)),
                row.rays.to_string(),
                number(row.build),
                number(row.trace),
            ]
        });
        view.screen.write_table(context.out, &words(title, header, rows))?;
    }
    Ok(())
}
