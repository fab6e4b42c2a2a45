//! `rtbench run`: measure, print, export; and go on where an earlier run ended. `rtbench merge`: the
//! parts of a run as one.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicUsize;

use scene_loading::source_names::name_of_path;

use crate::args::{ExportArgs, MergeArgs, RunArgs, TableArgs};
use crate::commands::measuring::{PlanResults, begin, exit_code, measure_rest, warn_of};
use crate::commands::run_outputs;
use crate::commands::run_state::RunState;
use crate::context::Context;
use crate::error::Error;
use crate::outputs::Outputs;
use measurement::journal::lines::{FinishedScene, Manifest, RecoveredRun};
use measurement::journal::{Journal, JournalError};
use measurement::plan::Plan;
use measurement::record::merge::{PartialRun, merge as merge_parts};
use measurement::record::{RunRecord, file};
use measurement::settings::RunSettings;
use measurement::system::interrupt::{self, InterruptedOutput, Mark};
use measurement::system::progress::Progress;
use studies::run::conclusions::conclude;
use studies::run::output;
use studies::run::view::View;

pub fn run(context: &mut Context<'_>, args: &RunArgs) -> Result<u8, Error> {
    if let Some(folder) = &args.resume {
        let exports = ExportArgs { output: Some(folder.clone()), ..args.exports.clone() };
        return resume(context, folder, &exports, &args.tables);
    }
    let settings = args.settings();
    let plan = plan_of(context, &settings)?;
    let record = begin(context.world, &context.command_line, &plan);
    let mut kept = RunState::default();
    let manifest = Manifest {
        asked: Some(settings),
        exports: names(&args.exports),
        ..manifest(context, &plan, &record)
    };
    run_outputs::refuse_unselected(&args.exports, || run_outputs::series_of(&plan))?;
    run_outputs::refuse_occupied(context, &args.exports, Some(&manifest))?;
    // the outputs first: where one of them is refused, no run has begun
    let outputs = run_outputs::of_run(&args.exports)?;
    if let Some(folder) = &args.exports.output {
        kept.journal = Some(Journal::begin(folder, manifest)?);
    }
    watch(context, &kept, args.exports.output.as_deref(), plan.scenes.len())?;
    let view = args.tables.view(context.screen());
    measure(context, &view, &plan, outputs, kept, record)
}

/// Finishes the run that was begun in a folder. Where to write, and which plugins to run, is taken
/// from this command line alone: the journal is a file that others may have had their hands on.
fn resume(
    context: &mut Context<'_>,
    folder: &Path,
    exports: &ExportArgs,
    tables: &TableArgs,
) -> Result<u8, Error> {
    let (journal, found) = Journal::resume(folder)?;
    let differs =
        |differences: String| JournalError::Differs { folder: folder.into(), differences };
    let Some(settings) = found.manifest.asked.clone() else {
        return Err(JournalError::NotAsked { path: journal.path().to_owned() }.into());
    };
    let (had, has) = (found.manifest.plugins.join(", "), context.plugins.names().join(", "));
    if had != has {
        let message = format!("plugins: was [{had}], is [{has}]; give the same with --plugin");
        return Err(differs(message).into());
    }
    let mut plan = plan_of(context, &settings)?;
    plan.set_view(&found.manifest.settings.view);
    let record = begin(context.world, &context.command_line, &plan);
    let named = found.manifest.exports.clone();
    let (kept, record) = go_on(context, folder, (journal, found), &plan, record)?;
    if let Some(name) = kept.finished.values().find_map(|s| context.plugins.changed_since(s)) {
        return Err(differs(format!("plugin {name}: its file has changed")).into());
    }
    let written = names(exports);
    // what they hold is older than what the run goes on to find
    for path in named.iter().filter(|path| !written.contains(path)) {
        context.warn(format_args!(
            "{path} belongs to this run but is no longer written; repeat its --export option"
        ));
    }
    let outputs = run_outputs::of_run(exports)?;
    watch(context, &kept, Some(folder), plan.scenes.len())?;
    measure(context, &tables.view(context.screen()), &plan, outputs, kept, record)
}

/// The files that a run is begun with, beside those in its folder.
fn names(exports: &ExportArgs) -> Vec<String> {
    let named = run_outputs::named(exports);
    named.iter().map(|path| name_of_path(path.as_os_str())).collect()
}

/// Plan of the run, including plugin rows. No plugin judges answers.
pub(super) fn plan_of<'c>(
    context: &Context<'c>,
    settings: &RunSettings,
) -> Result<Plan<'c>, Error> {
    let mut settings = settings.clone();
    context.plugins.add_rows(&mut settings.structures);
    let mut plan = Plan::of_run(&settings, context.registry, context.occluders, context.scenes)?;
    context.plugins.judge_nothing(&mut plan);
    Ok(plan)
}

fn measure(
    context: &mut Context<'_>,
    view: &View,
    plan: &Plan<'_>,
    outputs: Outputs<'_>,
    kept: RunState,
    record: RunRecord,
) -> Result<u8, Error> {
    context.warn_of_instructions();
    let measured = measure_rest(context, plan, outputs, kept, record, |out, record, scene| {
        output::write_scene(out, record, scene, view)
    })?;
    if !measured.record.summary.is_empty() {
        output::write_end(context.out, &measured.record, view)?;
    }
    Ok(exit_code(&measured))
}

/// Remaining work of an interrupted run, and its record, continued in `record`.
fn go_on(
    context: &mut Context<'_>,
    folder: &Path,
    (journal, found): (Journal, RecoveredRun),
    plan: &Plan<'_>,
    mut record: RunRecord,
) -> Result<(RunState, RunRecord), Error> {
    let RecoveredRun { manifest: was, finished, died_in, deaths, .. } = found;
    let mut differences = was.differences(&manifest(context, plan, &record));
    let progress = Progress::new(context.shows_progress(), finished.len() as u64, None);
    for (&i, FinishedScene { line, record: scene }) in &finished {
        progress.message(format!("{}: cannot verify that it is unchanged", scene.name));
        let (expected, has) = (plan.rows_in(i), scene.rows.len());
        if expected != has {
            let message = format!("scene {}: {has} of {expected} rows", scene.name);
            let (path, line) = (journal.path().to_owned(), *line);
            return Err(JournalError::NotOfPlan { path, line, message }.into());
        }
        // one without a row within its limits was never loaded
        let Some(known) = plan.scenes.get(i).filter(|_| !scene.sha256.is_empty()) else { continue };
        let sha256 = known.load()?.sha256;
        if sha256 != scene.sha256 {
            let name = known.name();
            differences.push(format!("scene {name}: sha256 was {}, is {sha256}", scene.sha256));
        }
        progress.step(context.clock.now());
    }
    progress.finish();
    if !differences.is_empty() {
        let (folder, differences) = (folder.to_owned(), differences.join("; "));
        return Err(JournalError::Differs { folder, differences }.into());
    }
    if let Some(known) = died_in.and_then(|i| plan.scenes.get(i)) {
        let name = known.name();
        context.warn(format_args!(
            "the previous run died while measuring '{name}' (killed, or out of memory?); retrying"
        ));
    }
    (record.command_line, record.started_unix_s) = (was.command_line, was.started_unix_s);
    let count = Arc::new(AtomicUsize::new(finished.len()));
    let finished = finished.into_iter().map(|(i, finished)| (i, finished.record)).collect();
    Ok((RunState { journal: Some(journal), finished, deaths, count }, record))
}

/// From here on a signal marks the run's journal and ends the process.
fn watch(
    context: &Context<'_>,
    kept: &RunState,
    folder: Option<&Path>,
    scenes: usize,
) -> Result<(), Error> {
    let temporary = context.environment.temporary.clone();
    let journal = match (&kept.journal, folder) {
        (Some(journal), Some(folder)) => {
            let last = journal.last_line(temporary)?;
            let mark: Mark = Box::new(move |signal| last.write(signal));
            Some((mark, folder.to_owned()))
        }
        _ => None,
    };
    let finished = Arc::clone(&kept.count);
    interrupt::watch(InterruptedOutput { journal, scenes, finished }).map_err(Error::Signals)
}

/// Identity of the run for its journal, without the request.
fn manifest(context: &Context<'_>, plan: &Plan<'_>, record: &RunRecord) -> Manifest {
    Manifest {
        schema_version: record.schema_version,
        tool: record.tool.clone(),
        program_sha256: (context.world.program_sha256)(),
        compiler: record.compiler.clone(),
        machine: record.machine.clone(),
        settings: record.settings.clone(),
        rounds: format!("{:?}", plan.rounds),
        scenes: record.planned.clone(),
        rows: plan.rows.iter().map(|row| row.label()).collect(),
        asked: None,
        plugins: context.plugins.names(),
        exports: Vec::new(),
        command_line: record.command_line.clone(),
        started_unix_s: record.started_unix_s,
    }
}

/// `rtbench merge`: the parts of a run, printed and exported like a run; returns the exit code of the
/// whole.
pub fn merge(context: &mut Context<'_>, args: &MergeArgs) -> Result<u8, Error> {
    let read = |path: &PathBuf| Ok(PartialRun { record: file::read(path)?, path: path.clone() });
    let parts = args.parts.iter().map(read).collect();
    run_outputs::refuse_occupied(context, &args.exports, None)?;
    let mut record = merge_parts(parts, args.mixed_machines)?;
    run_outputs::refuse_unselected(&args.exports, || run_outputs::series_in(&record))?;
    conclude(&mut record);
    record.command_line = context.command_line.clone();
    // not before: parts that do not fit leave no empty files
    let mut outputs = run_outputs::of_run(&args.exports)?;
    outputs.write(&record, true)?;
    let view = View::on(context.screen());
    for scene in &record.scenes {
        warn_of(context, scene);
        output::write_scene(context.out, &record, scene, &view)?;
    }
    if !record.summary.is_empty() {
        output::write_end(context.out, &record, &view)?;
    }
    Ok(exit_code(&PlanResults { record, failures: Vec::new(), disturbed: false }))
}
