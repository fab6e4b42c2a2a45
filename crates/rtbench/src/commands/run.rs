//! `rtbench run`: measure, print, export; and go on where an earlier run, or `rtbench scale`, ended.

use std::ffi::OsString;
use std::path::Path;

use clap::Parser;
use scene_loading::source_names::path_of_name;

use crate::args::{Cli, Color, Command, ExportArgs, PluginArgs, RunArgs, TableArgs};
use crate::commands::measuring::{Kept, begin, exit_code, measure_rest, warn_of};
use crate::commands::resumable::{Begun, go_on, manifest_of, watch};
use crate::commands::run_outputs;
use crate::commands::scale;
use crate::context::Context;
use crate::error::Error;
use crate::exports::outputs::Outputs;
use crate::recorded_view;
use measurement::journal::{Journal, JournalError};
use measurement::plan::Plan;
use measurement::record::RunRecord;
use studies::run::text;
use studies::run::view::View;

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
        let exports = ExportArgs { output: Some(folder.clone()), ..args.exports.clone() };
        let resumed = Resumed { folder, exports: &exports, plugins: &args.plugins };
        return resume(context, resumed, &args.tables, color);
    }
    let plan = plan_of(context, args)?;
    let record = begin(context.world, &context.command_line, &plan);
    let mut kept = Kept::default();
    let manifest = manifest_of(context, &plan, &record, arguments);
    run_outputs::refuse_occupied(context, &args.exports, Some(&manifest))?;
    // the outputs first: where one of them is refused, no run has begun
    let outputs = run_outputs::of_run(&args.exports)?;
    if let Some(folder) = &args.exports.output {
        kept.journal = Some(Journal::begin(folder, manifest)?);
    }
    watch(context, &kept, args.exports.output.as_deref(), plan.scenes.len())?;
    let view = args.tables.view(context.terminal.width(), context.terminal.colors(color));
    measure(context, &view, &plan, outputs, kept, record)
}

/// What the command line says of a run that goes on.
struct Resumed<'a> {
    folder: &'a Path,
    exports: &'a ExportArgs,
    plugins: &'a PluginArgs,
}

/// Finishes the run that was begun in a folder. Where to write, and which plugins to run, is taken from this
/// command line alone: the journal is a file that others may have had their hands on.
fn resume(
    context: &mut Context<'_>,
    Resumed { folder, exports, plugins }: Resumed<'_>,
    tables: &TableArgs,
    color: Color,
) -> Result<u8, Error> {
    let (journal, found) = Journal::resume(folder)?;
    let differs =
        |differences: String| JournalError::Differs { folder: folder.into(), differences };
    let arguments = found.manifest.arguments.iter().map(|a| path_of_name(a).into_os_string());
    let arguments = std::iter::once(OsString::from("rtbench")).chain(arguments);
    let command = Cli::try_parse_from(arguments).map(|cli| cli.command);
    let begun = Begun { folder, journal, found };
    let args = match command {
        Ok(Command::Run(args)) if args.resume.is_none() => args,
        Ok(Command::Scale(args)) => return scale::resume(context, &args, exports, color, begun),
        Ok(_) => return Err(differs("arguments: expected those of `run`".into()).into()),
        Err(error) => return Err(differs(format!("arguments: {error}")).into()),
    };
    let had = args.plugins.plugin.len();
    if had != plugins.plugin.len() {
        let now = plugins.plugin.len();
        let message = format!("{had} plugins, {now} now: name the same again with --plugin");
        return Err(differs(message).into());
    }
    let mut plan = plan_of(context, &args)?;
    recorded_view::apply(&begun.found.manifest.settings, &mut plan).map_err(differs)?;
    let record = begin(context.world, &context.command_line, &plan);
    let (kept, record) = go_on(context, begun, &plan, record)?;
    if let Some(name) = kept.finished.values().find_map(|s| context.plugins.changed_since(s)) {
        return Err(differs(format!("plugin {name}: its file is another")).into());
    }
    for path in run_outputs::left_behind(&args.exports, exports) {
        context.warn(format_args!(
            "{} was begun with this run and is not written any more: name it again with its --export option",
            path.display()
        ));
    }
    let outputs = run_outputs::of_run(exports)?;
    watch(context, &kept, Some(folder), plan.scenes.len())?;
    measure(
        context,
        &tables.view(context.terminal.width(), context.terminal.colors(color)),
        &plan,
        outputs,
        kept,
        record,
    )
}

/// What is measured, the rows of plugins among it. No plugin judges answers.
pub(super) fn plan_of<'c>(context: &Context<'c>, args: &RunArgs) -> Result<Plan<'c>, Error> {
    let mut settings = args.settings();
    context.plugins.add_rows(&mut settings.structures);
    let mut plan = Plan::of_run(&settings, context.registry, context.occluders, context.scenes)?;
    context.plugins.judge_nothing(&mut plan);
    Ok(plan)
}

fn measure(
    context: &mut Context<'_>,
    view: &View,
    plan: &Plan<'_>,
    mut outputs: Outputs<'_>,
    kept: Kept,
    record: RunRecord,
) -> Result<u8, Error> {
    context.warn_of_instructions();
    let has_tables = !outputs.are_printed();
    let measured =
        measure_rest(context, plan, &mut outputs, kept, record, |context, record, scene| {
            warn_of(context, scene);
            if has_tables {
                text::write_scene(context.out, record, scene, view)?;
                context.out.flush()?;
            }
            Ok(())
        })?;
    if has_tables && !measured.record.summary.is_empty() {
        text::write_end(context.out, &measured.record, view)?;
        context.out.flush()?;
    }
    Ok(exit_code(&measured))
}
