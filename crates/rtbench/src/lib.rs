//! Benchmark harness for ray-tracing acceleration structures.
//!
//! The way of a run: [`args`] (syntax) -> [`plan`] (validated) -> [`scene_run`]: [`reference`]
//! and [`oracle`] (what is right), [`check`] (is each row right?), [`measure`] (rounds in the
//! order of [`schedule`]) -> [`statistics`] -> [`record`] -> [`journal`], [`export`]. A [`sweep`] is
//! such a run whose rows are the values of one parameter; the [`gate`] holds a run against an earlier
//! one.

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

pub mod accuracy;
pub mod args;
pub mod baselines;
pub mod batches;
pub mod callgrind;
pub mod check;
pub mod child_process;
pub mod clock;
pub mod commands;
pub mod context;
#[allow(clippy::indexing_slicing)]
pub mod cost;
pub mod duration;
pub mod effect_table;
pub mod error;
pub mod export;
pub mod gate;
#[allow(clippy::indexing_slicing)]
pub mod image_error;
pub mod interrupt;
pub mod journal;
pub mod like;
pub mod machine;
#[allow(clippy::indexing_slicing)]
pub mod measure;
pub mod measured_row;
pub mod metrics;
pub mod oracle;
pub mod panics;
pub mod plan;
pub mod pools;
pub mod pressure;
pub mod progress;
pub mod random;
pub mod ray_overrides;
pub mod record;
pub mod record_file;
pub mod reference;
pub mod reproduce;
pub mod rows;
pub mod scene_run;
pub mod scene_source;
pub mod schedule;
#[allow(clippy::indexing_slicing)]
pub mod statistics;
pub mod strides;
mod suggest;
pub mod summary;
#[allow(clippy::indexing_slicing)]
pub mod sweep;
#[allow(clippy::indexing_slicing)]
pub mod tracer_comparison;
#[allow(clippy::indexing_slicing)]
pub mod verify;

use std::ffi::OsString;
use std::io::{self, Write};
use std::process::ExitCode;

use accel_core::occluders;
use accel_core::structures::{Entry, REGISTRY};
use clap::Parser;

use crate::args::{Cli, Command};
use crate::clock::SystemClock;
use crate::context::{Context, Environment, Terminal, Verbosity};
use crate::error::{Error, FAILURE, SUCCESS, USAGE};
use crate::scene_source::Installed;

/// The whole program on the process's own arguments, outputs and clock.
pub fn main() -> ExitCode {
    main_over(REGISTRY)
}

/// The same over structures of the caller's choice.
pub fn main_over(registry: &[Entry]) -> ExitCode {
    panics::keep_quiet();
    interrupt::arm();
    let arguments: Vec<OsString> = std::env::args_os().collect();
    let command_line = arguments.iter().map(|a| a.to_string_lossy().into_owned()).collect();
    let mut out = io::stdout().lock();
    let mut err = io::stderr();
    let mut context = Context {
        registry,
        occluders: occluders::REGISTRY,
        scenes: &Installed,
        clock: &SystemClock::default(),
        out: &mut out,
        err: &mut err,
        command_line,
        terminal: Terminal::detect(),
        verbosity: Verbosity::Normal,
        environment: Environment::detect(),
    };
    let ended = panics::caught(|| run(&mut context, arguments));
    ExitCode::from(ended.unwrap_or_else(|panicked| {
        let _ = writeln!(io::stderr(), "error: {panicked}; this is a defect of rtbench");
        FAILURE
    }))
}

/// The whole program on the given arguments, program name first; returns the exit code.
pub fn run(
    context: &mut Context<'_>,
    arguments: impl IntoIterator<Item = impl Into<OsString> + Clone>,
) -> u8 {
    let arguments: Vec<OsString> = arguments.into_iter().map(Into::into).collect();
    let cli = match Cli::try_parse_from(&arguments) {
        Ok(cli) => cli,
        Err(error) => return usage(context, &error),
    };
    context.verbosity = match (cli.quiet, cli.verbose) {
        (true, _) => Verbosity::Quiet,
        (_, true) => Verbosity::Verbose,
        _ => Verbosity::Normal,
    };
    let ended = match &cli.command {
        Command::Run(args) => commands::run::run(context, args, cli.color, &arguments),
        Command::Sweep(args) => commands::sweep::run(context, args, cli.color),
        Command::List(args) => commands::list::run(context, args).map(|()| SUCCESS),
        Command::Render(args) => commands::render::run(context, args, cli.color).map(|()| SUCCESS),
        Command::Cost(args) => commands::cost::run(context, args, cli.color).map(|()| SUCCESS),
        Command::CompareTracers(args) => commands::compare_tracers::run(context, args, cli.color),
        Command::Scenes(args) => commands::scenes::run(context, &args.action),
        Command::Verify(args) => commands::verify::run(context, args, cli.color),
        Command::Accuracy(args) => commands::accuracy::run(context, args, cli.color),
        Command::Reproduce(args) => commands::reproduce::run(context, args),
        Command::Check(args) => commands::check::run(context, args, cli.color),
        Command::Baseline(args) => commands::baseline::run(context, args, cli.color),
        Command::Child(args) => commands::child::run(context, args),
    };
    match ended {
        Ok(code) => code,
        Err(error) if error.is_closed_pipe() && !cli.command.measures() => SUCCESS,
        Err(error) if error.is_closed_pipe() => {
            let _ = writeln!(
                context.err,
                "error: standard output was closed before the run was finished; what is finished \
                 is in the output files"
            );
            FAILURE
        }
        Err(error) => {
            let _ = writeln!(context.err, "error: {error}");
            if error.exit_code() == USAGE {
                let _ = writeln!(context.err, "For what there is, try 'rtbench list --help'.");
            }
            error.exit_code()
        }
    }
}

/// Help and version on standard output, usage errors on standard error.
fn usage(context: &mut Context<'_>, error: &clap::Error) -> u8 {
    let text = error.render();
    let written = if error.use_stderr() {
        write!(context.err, "{text}")
    } else {
        write!(context.out, "{text}").and_then(|()| context.out.flush())
    };
    match written.map_err(Error::from) {
        _ if error.use_stderr() => USAGE,
        Err(e) if !e.is_closed_pipe() => FAILURE,
        _ => SUCCESS,
    }
}
