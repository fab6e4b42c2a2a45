//! `rtbench run`: measure, print, export; and go on where an earlier run, or `rtbench scale`, ended.

use std::ffi::OsString;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicUsize;

use clap::Parser;
use scene_loading::source_names::{name_of_path, path_of_name};

use crate::args::{Cli, Color, Command, RunArgs};
use crate::commands::measuring::{Kept, begin, exit_code, measure_rest, warn_of};
use crate::commands::scale;
use crate::context::Context;
use crate::error::Error;
use crate::export::files::Outputs;
use crate::export::text;
use crate::interrupt::{self, Unfinished};
use crate::journal::lines::{Manifest, Recovered};
use crate::journal::{Journal, JournalError};
use crate::plan::Plan;
use crate::record::RunRecord;

/// Runs and returns the exit code. `arguments` are those of the process, program first.
///
/// # Errors
/// [`Error`] for what ends the run early: the command line, a scene, an output.
pub fn run(
    context: &mut Context<'_>,
    args: &RunArgs,
    color: Color,
    arguments: &[OsString],
) -> Result<u8, Error> {
    if let Some(folder) = &args.resume {
        return resume(context, folder, color);
    }
    let plan = Plan::new(args, context.registry, context.occluders, context.scenes)?;
    let record = begin(context, &plan);
    let mut kept = Kept::default();
    // the outputs first: where one of them is refused, no run has begun
    let outputs = Outputs::of_run(&args.exports)?;
    if let Some(folder) = &args.exports.output {
        kept.journal = Some(journal_in(context, folder, &plan, &record, arguments)?);
    }
    watch(&kept, args.exports.output.as_deref(), plan.scenes.len())?;
    measure(context, color, &plan, outputs, kept, record)
}

/// Begins the journal of a run in its folder, which is there.
///
/// # Errors
/// Those of [`Journal::begin`].
pub(super) fn journal_in(
    context: &Context<'_>,
    folder: &Path,
    plan: &Plan<'_>,
    record: &RunRecord,
    arguments: &[OsString],
) -> Result<Journal, Error> {
    let arguments = arguments.iter().skip(1).map(|a| name_of_path(a)).collect();
    Journal::begin(folder, manifest(context, plan, record, arguments))
}

/// A run that was begun in a folder, and what it left there.
pub(super) struct Begun<'f> {
    /// The folder.
    pub folder: &'f Path,
    journal: Journal,
    found: Recovered,
}

/// Finishes the run that was begun in a folder.
fn resume(context: &mut Context<'_>, folder: &Path, color: Color) -> Result<u8, Error> {
    let (journal, found) = Journal::resume(folder)?;
    let differs =
        |differences: String| JournalError::Differs { folder: folder.into(), differences };
    let arguments = found.manifest.arguments.iter().map(|a| path_of_name(a).into_os_string());
    let arguments = std::iter::once(OsString::from("rtbench")).chain(arguments);
    let command = Cli::try_parse_from(arguments).map(|cli| cli.command);
    let begun = Begun { folder, journal, found };
    let mut args = match command {
        Ok(Command::Run(args)) if args.resume.is_none() => args,
        Ok(Command::Scale(args)) => return scale::resume(context, &args, color, begun),
        Ok(_) => return Err(differs("arguments: expected those of `run`".into()).into()),
        Err(error) => return Err(differs(format!("arguments: {error}")).into()),
    };
    args.exports.output = Some(folder.to_owned());
    let plan = Plan::new(&args, context.registry, context.occluders, context.scenes)?;
    let record = begin(context, &plan);
    let (kept, record) = go_on(context, begun, &plan, record)?;
    let outputs = Outputs::of_run(&args.exports)?;
    watch(&kept, Some(folder), plan.scenes.len())?;
    measure(context, color, &plan, outputs, kept, record)
}

/// What is left to do of a run that was begun, and its record, which goes on with `record`.
///
/// # Errors
/// [`JournalError::Differs`] where the plan is not that of the run.
pub(super) fn go_on(
    context: &mut Context<'_>,
    begun: Begun<'_>,
    plan: &Plan<'_>,
    mut record: RunRecord,
) -> Result<(Kept, RunRecord), Error> {
    let Begun { folder, journal, found } = begun;
    let Recovered { manifest: was, finished, died_in, .. } = found;
    let mut differences = was.differences(&manifest(context, plan, &record, Vec::new()));
    for (&i, scene) in &finished {
        // one without a row within its limits was never loaded
        let Some(known) = plan.scenes.get(i).filter(|_| !scene.sha256.is_empty()) else { continue };
        let sha256 = known.load()?.sha256;
        if sha256 != scene.sha256 {
            let name = known.name();
            differences.push(format!("scene {name}: sha256 was {}, is {sha256}", scene.sha256));
        }
    }
    if !differences.is_empty() {
        let (folder, differences) = (folder.to_owned(), differences.join("; "));
        return Err(JournalError::Differs { folder, differences }.into());
    }
    if let Some(known) = died_in.and_then(|i| plan.scenes.get(i)) {
        let name = known.name();
        context.warn(format_args!(
            "the run ended in scene {name} without a word: killed, or out of memory; trying again"
        ));
    }
    (record.command_line, record.started_unix_s) = (was.command_line, was.started_unix_s);
    let count = Arc::new(AtomicUsize::new(finished.len()));
    Ok((Kept { journal: Some(journal), finished, count }, record))
}

/// From here on a signal marks the run's journal and ends the process.
///
/// # Errors
/// [`Error::Signals`], the journal's.
pub(super) fn watch(kept: &Kept, folder: Option<&Path>, scenes: usize) -> Result<(), Error> {
    let journal = match (&kept.journal, folder) {
        (Some(journal), Some(folder)) => Some((journal.handle()?, folder.to_owned())),
        _ => None,
    };
    let finished = Arc::clone(&kept.count);
    interrupt::watch(Unfinished { journal, scenes, finished }).map_err(Error::Signals)
}

fn measure(
    context: &mut Context<'_>,
    color: Color,
    plan: &Plan<'_>,
    mut outputs: Outputs<'_>,
    kept: Kept,
    record: RunRecord,
) -> Result<u8, Error> {
    let colors = context.terminal.colors(color);
    let has_tables = !outputs.are_printed();
    let measured =
        measure_rest(context, plan, &mut outputs, kept, record, |context, record, scene| {
            warn_of(context, scene);
            if has_tables {
                text::write_scene(context.out, record, scene, colors)?;
                context.out.flush()?;
            }
            Ok(())
        })?;
    if has_tables && !measured.record.summary.is_empty() {
        text::write_summary(context.out, &measured.record, colors)?;
        context.out.flush()?;
    }
    Ok(exit_code(&measured))
}

/// What the run is, for its journal.
fn manifest(
    context: &Context<'_>,
    plan: &Plan<'_>,
    record: &RunRecord,
    arguments: Vec<String>,
) -> Manifest {
    Manifest {
        schema_version: record.schema_version,
        tool: record.tool.clone(),
        program_sha256: context.world.program_sha256(),
        compiler: record.compiler.clone(),
        machine: record.machine.clone(),
        settings: record.settings.clone(),
        rounds: format!("{:?}", plan.rounds),
        scenes: record.planned.clone(),
        rows: plan.rows.iter().map(|row| row.label()).collect(),
        arguments,
        command_line: record.command_line.clone(),
        started_unix_s: record.started_unix_s,
    }
}
