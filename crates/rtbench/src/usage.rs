//! Handles invalid command lines, help and version.

use clap::CommandFactory;
use clap::error::{ContextKind, ContextValue};

use crate::args::Cli;
use crate::context::Context;
use crate::error::Error;
use crate::exit_code::{FAILURE, SUCCESS, USAGE};
use measurement::settings::choice;
use presentation::outside::line;

/// Help and version on standard output, usage errors on standard error.
pub fn usage(context: &mut Context<'_>, mut error: clap::Error) -> u8 {
    suggest_command(&mut error);
    show_hidden(&mut error);
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

/// Shows the arguments of the error, escaped.
fn show_hidden(error: &mut clap::Error) {
    let shown = |text: &String| line(text).into_owned();
    let typed: Vec<(ContextKind, ContextValue)> = error
        .context()
        .filter_map(|(kind, value)| match value {
            ContextValue::String(text) => Some((kind, ContextValue::String(shown(text)))),
            ContextValue::Strings(all) => {
                Some((kind, ContextValue::Strings(all.iter().map(shown).collect())))
            }
            _ => None,
        })
        .collect();
    for (kind, value) in typed {
        error.insert(kind, value);
    }
}

/// Clap does not see that `rnu` is `run`.
fn suggest_command(error: &mut clap::Error) {
    let (typed, known) = (ContextKind::InvalidSubcommand, ContextKind::SuggestedSubcommand);
    if let (Some(ContextValue::String(typed)), None) = (error.get(typed), error.get(known)) {
        let cli = Cli::command();
        let meant = choice::nearest(typed, cli.get_subcommands().map(clap::Command::get_name));
        if let Some(meant) = meant.map(str::to_owned) {
            error.insert(known, ContextValue::Strings(vec![meant]));
        }
    }
}
