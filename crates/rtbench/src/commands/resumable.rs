//! Resuming interrupted runs: their journals, and the work that is left.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicUsize;

use measurement::journal::lines::{FinishedScene, Manifest, RecoveredRun};
use measurement::journal::{Journal, JournalError};
use measurement::plan::Plan;
use measurement::record::RunRecord;
use measurement::system::interrupt::{self, InterruptedOutput, Mark};
use measurement::system::progress::Progress;

use crate::commands::run_state::RunState;
use crate::context::Context;
use crate::error::Error;

/// A run that was begun in a folder, and what it left there.
pub struct ResumedRun<'f> {
    pub folder: &'f Path,
    pub journal: Journal,
    /// Contents of the journal.
    pub found: RecoveredRun,
}

/// Remaining work of an interrupted run, and its record, continued in `record`.
pub fn go_on(
    context: &mut Context<'_>,
    begun: ResumedRun<'_>,
    plan: &Plan<'_>,
    mut record: RunRecord,
) -> Result<(RunState, RunRecord), Error> {
    let ResumedRun { folder, journal, found } = begun;
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
pub fn watch(
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
pub fn manifest(context: &Context<'_>, plan: &Plan<'_>, record: &RunRecord) -> Manifest {
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
        asked: None,
        plugins: context.plugins.names(),
        exports: Vec::new(),
        command_line: record.command_line.clone(),
        started_unix_s: record.started_unix_s,
    }
}
