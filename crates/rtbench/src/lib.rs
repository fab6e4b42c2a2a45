//! Benchmark harness for ray-tracing acceleration structures.
//!
//! The way of a run: [`args`] (syntax) -> [`measurement::settings`] -> [`measurement::plan`]
//! (validated) -> [`measurement::rounds`]: what is right, is each row right, rounds in seeded
//! random order -> [`measurement::record`] -> the journal, tables ([`studies::run`]) and
//! [`outputs`]. A sweep is such a run whose rows are the values of one parameter, or whose scenes
//! are the sizes of one scene. [`comparison`] puts records side by side, the [`gate`] compares a
//! run with an earlier one, a [`report`] is made of a folder of them.

// What a command line or a file says can make nothing panic. Modules that index lists of their own
// making say so.
#![cfg_attr(
    not(test),
    deny(
        clippy::unwrap_used,
        clippy::expect_used,
        clippy::indexing_slicing,
        clippy::panic,
        clippy::unreachable
    )
)]

pub mod args;
pub mod baselines;
mod command_line;
pub mod commands;
#[allow(clippy::indexing_slicing)]
pub mod comparison;
pub mod context;
pub mod error;
pub mod foreign_row;
pub mod gate;
pub mod history;
mod measure;
pub mod outputs;
pub mod plugin_rows;
pub mod program;
pub mod replan;
pub mod report;
pub mod set_options;

use std::ffi::OsString;
use std::io::{self, Write};
use std::path::Path;
use std::process::ExitCode;

use accel_core::occluders;
use accel_core::query::batch::AVX512_VARIABLE;
use accel_core::structures::{Entry, REGISTRY};
use clap::{CommandFactory, FromArgMatches};

use crate::args::{Cli, Command, RaysAction};
use crate::command_line::{GivenView, files_of_folder, files_read, named_files, recorded, usage};
use crate::context::{Context, Environment, Terminal, Verbosity};
use crate::error::{Error, FAILURE, SUCCESS};
use crate::outputs::{OutputError, refuse_shared};
use crate::plugin_rows::Plugins;
use crate::set_options::{added_by_set, join};
use measurement::plan::error::PlanError;
use measurement::scenes::{InstalledScenes, LoadError};
use measurement::system::clock::SystemClock;
use measurement::system::{files, interrupt, panics};
use presentation::outside::{Guard, line};

pub use accel_core;
pub use measure::measure;
pub use measurement;

/// The whole program on the process's own arguments, outputs and clock.
pub fn main() -> ExitCode {
    main_over(REGISTRY)
}

/// The same with structures of the caller's beside ours: each a line of
/// [`entry!`](accel_core::entry).
///
/// ```no_run
/// use rtbench::accel_core::structures::uniform_grid::{self, UniformGrid};
/// use rtbench::accel_core::{entry, structure::StructureInfo};
///
/// // a structure of yours has a type and an INFO of its own
/// static INFO: StructureInfo = StructureInfo {
///     params: uniform_grid::INFO.params,
///     ..StructureInfo::new("my-grid", "the uniform grid under another name")
/// };
///
/// fn main() -> std::process::ExitCode {
///     rtbench::main_with(&[entry!(UniformGrid, INFO)])
/// }
/// ```
#[warn(missing_docs)]
pub fn main_with(own: &[Entry]) -> ExitCode {
    main_over(&[REGISTRY, own].concat())
}

/// The same over structures of the caller's choice, and no others. A line that cannot be used
/// ([`RegistryError`](accel_core::registry::RegistryError)) ends the program with exit code 1.
pub fn main_over(registry: &[Entry]) -> ExitCode {
    let taken: Vec<&str> = occluders::REGISTRY.iter().map(|entry| entry.info.name).collect();
    if let Err(error) = accel_core::registry::check(registry, &taken) {
        let _ = writeln!(io::stderr(), "error: {error}");
        return ExitCode::from(FAILURE);
    }
    if let Some(value) = std::env::var_os(AVX512_VARIABLE).filter(|value| value != "off") {
        let value = value.to_string_lossy();
        let _ = writeln!(io::stderr(), "error: {AVX512_VARIABLE} is \"{value}\", expected \"off\"");
        return ExitCode::from(FAILURE);
    }
    panics::keep_quiet();
    interrupt::arm();
    // without the signal a write beyond the limit ends the process: nothing is lost that was kept
    // before
    let _ = files::refuse_writes_beyond();
    let arguments: Vec<OsString> = std::env::args_os().collect();
    let command_line = arguments.iter().map(|a| a.to_string_lossy().into_owned()).collect();
    let mut out = io::stdout().lock();
    let mut err = io::stderr();
    let (clock, world) = (SystemClock::default(), program::world());
    let mut context = Context {
        command_line,
        terminal: Terminal::detect(),
        environment: Environment::detect(),
        ..Context::new(registry, &InstalledScenes, &clock, &world, &mut out, &mut err)
    };
    let folder = std::env::current_dir().ok();
    let ended = panics::caught(|| run_in(&mut context, arguments, folder.as_deref()));
    ExitCode::from(ended.unwrap_or_else(|panicked| {
        let panicked = line(&panicked.to_string()).into_owned();
        let _ = writeln!(io::stderr(), "error: {panicked}; this is a defect of rtbench");
        FAILURE
    }))
}

/// The whole program on the given arguments, program name first; returns the exit code.
pub fn run(
    context: &mut Context<'_>,
    arguments: impl IntoIterator<Item = impl Into<OsString> + Clone>,
) -> u8 {
    run_in(context, arguments, None)
}

/// The same within a folder: paths in it are recorded relative to it. What is printed is guarded:
/// only annotations are orders to a CI job.
pub fn run_in(
    context: &mut Context<'_>,
    arguments: impl IntoIterator<Item = impl Into<OsString> + Clone>,
    folder: Option<&Path>,
) -> u8 {
    let own = context.reborrowed();
    let (out, err) = (&mut Guard::new(own.out), &mut Guard::new(own.err));
    let mut guarded = Context { out, err, ..own };
    let code = run_guarded(&mut guarded, arguments, folder);
    for annotation in context.annotations.take() {
        let _ = writeln!(context.err, "{annotation}");
    }
    code
}

fn run_guarded(
    context: &mut Context<'_>,
    arguments: impl IntoIterator<Item = impl Into<OsString> + Clone>,
    folder: Option<&Path>,
) -> u8 {
    let mut arguments: Vec<OsString> = arguments.into_iter().map(Into::into).collect();
    let mut cli = match parsed(context, &arguments) {
        Ok(cli) => cli,
        Err(error) => return usage(context, error),
    };
    let mut command_line = context.command_line.clone();
    let (source, allow_outside) = (context.scenes, cli.allow_outside);
    let scenes = GivenView { source, allow_outside, view: cli.view.options() };
    match added_by_set(&arguments, &scenes) {
        Err(error) => return failed(context, &cli, &error.into()),
        Ok(added) => {
            join(&mut command_line, added.iter().map(|a| a.to_string_lossy().into_owned()));
            join(&mut arguments, added);
        }
    }
    cli = match parsed(context, &arguments) {
        Ok(cli) => cli,
        Err(error) => return usage(context, error),
    };
    let mut own = Context {
        scenes: &scenes,
        command_line: recorded(&command_line, folder),
        color: cli.color,
        verbosity: match (cli.quiet, cli.verbose) {
            (true, _) => Verbosity::Quiet,
            (_, true) => Verbosity::Verbose,
            _ => Verbosity::Normal,
        },
        overwrite: cli.overwrite,
        ..context.reborrowed()
    };
    let ended = match refuse_files(&cli) {
        Ok(()) => with_plugins(&mut own, &cli),
        Err(error) => Err(error),
    };
    ended.unwrap_or_else(|error| failed(&mut own, &cli, &error))
}

/// Refuses to write two outputs to one file, or over what is there unless that is asked for.
fn refuse_files(cli: &Cli) -> Result<(), Error> {
    let named = named_files(&cli.command);
    let all = [files_of_folder(&cli.command), named.clone()].concat();
    refuse_shared(&all, &files_read(&cli.command))?;
    if named.iter().any(|path| path.as_os_str() == "-") {
        return Err(OutputError::StandardOutput.into());
    }
    if cli.overwrite { Ok(()) } else { Ok(outputs::refuse_files(named)?) }
}

/// Does what the command line says, with the plugins that it names.
fn with_plugins(context: &mut Context<'_>, cli: &Cli) -> Result<u8, Error> {
    let Some(args) = cli.command.plugins().filter(|args| !args.plugin.is_empty()) else {
        return dispatched(context, cli);
    };
    let occluders = context.occluders.iter().map(|entry| entry.info.name);
    let program = context.environment.program.as_ref();
    // a crash in one hard case says nothing of the next
    let restarts = matches!(cli.command, Command::Verify(_));
    let (plugins, registry) = Plugins::load(args, context.registry, occluders, program, restarts)?;
    let mut within = Context { registry: &registry, plugins, ..context.reborrowed() };
    dispatched(&mut within, cli)
}

/// Does what the command line says. What a command printed is out when it has ended.
fn dispatched(context: &mut Context<'_>, cli: &Cli) -> Result<u8, Error> {
    let code = match &cli.command {
        Command::Run(args) => commands::run::run(context, args),
        Command::Sweep(args) => commands::sweep::run(context, args),
        Command::Animate(args) => commands::animate::run(context, args, &cli.view.options()),
        Command::Explain(args) => commands::sweep::explain(context, args),
        Command::Compare(args) => commands::compare::run(context, args),
        Command::List(args) => commands::list::run(context, args),
        Command::Render(args) => commands::render::run(context, args),
        Command::Show(args) => commands::show::run(context, args),
        Command::Cost(args) => commands::cost::run(context, args),
        Command::CompareTracers(args) => commands::compare_tracers::run(context, args),
        Command::Scenes(args) => commands::scenes::run(context, args),
        Command::Rays(RaysAction::Export(args)) => commands::rays::export(context, args),
        Command::Rays(RaysAction::Trace(args)) => commands::rays::trace_rays(context, args),
        Command::Rays(RaysAction::Check(args)) => commands::rays::check_hits(context, args),
        Command::Verify(args) => commands::verify::run(context, args),
        Command::Accuracy(args) => commands::accuracy::run(context, args),
        Command::Report(args) => commands::report::run(context, args),
        Command::History(args) => commands::report::history(context, args),
        Command::Reproduce(args) => commands::reproduce::run(context, args),
        Command::Check(args) => commands::check::run(context, args),
        Command::Baseline(args) => commands::baseline::run(context, args),
        Command::Child(args) => commands::child::run(context, args),
        Command::Merge(args) => commands::run::merge(context, args),
        Command::Doctor(args) => commands::doctor::run(context, args),
        Command::Generate(text) => commands::generate::run(context, text),
    }?;
    context.out.flush()?;
    Ok(code)
}

/// Says why a command ended early; returns the exit code.
fn failed(context: &mut Context<'_>, cli: &Cli, error: &Error) -> u8 {
    if error.is_closed_pipe() {
        if !cli.command.measures() {
            return SUCCESS;
        }
        context.error(
            "standard output was closed before the run finished; finished scenes are in the \
             output files",
        );
        return FAILURE;
    }
    context.error(error);
    if let Some(listed) = listed_by(&cli.command, error) {
        context.write_err(&format!("To list valid names: rtbench list {listed}"));
    }
    error.exit_code()
}

/// The list that has what was not found.
fn listed_by(command: &Command, error: &Error) -> Option<&'static str> {
    match error {
        Error::Plan(PlanError::UnknownName { what: "structure", .. } | PlanError::Param { .. }) => {
            (!matches!(command, Command::List(_))).then_some("structures")
        }
        Error::Plan(PlanError::Scene(LoadError::UnknownScene { .. }))
        | Error::Load(LoadError::UnknownScene { .. }) => match command {
            Command::Animate(_) => Some("animations"),
            _ => Some("scenes"),
        },
        _ => None,
    }
}

/// The command line; help is as wide as the terminal.
fn parsed(context: &Context<'_>, arguments: &[OsString]) -> Result<Cli, clap::Error> {
    let mut command = Cli::command();
    if let Some(columns) = context.terminal.columns {
        command = command.term_width(columns);
    }
    let mut matches = command.try_get_matches_from_mut(arguments)?;
    Cli::from_arg_matches_mut(&mut matches).map_err(|error| error.format(&mut command))
}
