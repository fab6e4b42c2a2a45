//! `rtbench generate`: what the program says of itself, for other programs.

use clap::CommandFactory;
use clap_mangen::Man;

use crate::args::{Cli, CompletionsArgs, ManArgs, SchemaArgs, SchemaOf};
use crate::context::Context;
use crate::error::Error;
use crate::schema;
use measurement::plan::error::PlanError;
use measurement::system::created::WriteError;

pub fn schema(context: &mut Context<'_>, args: &SchemaArgs) -> Result<(), Error> {
    let text = match args.what {
        SchemaOf::RunRecord => schema::RUN_RECORD,
        SchemaOf::GithubActionBenchmark => schema::GITHUB_ACTION_BENCHMARK,
        SchemaOf::BencherMetricFormat => schema::BENCHER_METRIC_FORMAT,
        SchemaOf::Scene => schema::SCENE,
    };
    context.out.write_all(text.as_bytes())?;
    Ok(context.out.flush()?)
}

pub fn completions(context: &mut Context<'_>, args: &CompletionsArgs) -> Result<(), Error> {
    // the library takes no error of its writer
    let mut text = Vec::new();
    clap_complete::generate(args.shell, &mut Cli::command(), "rtbench", &mut text);
    context.out.write_all(&text)?;
    Ok(context.out.flush()?)
}

/// The command line with all that follows from what is declared.
fn built() -> clap::Command {
    let mut cli = Cli::command().disable_help_subcommand(true).long_version(None::<&str>);
    cli.build();
    cli
}

/// The pages of a command and of those below it that are not hidden.
fn pages(command: &clap::Command) -> Vec<Man> {
    let shown = command.get_subcommands().filter(|below| !below.is_hide_set());
    let mut all: Vec<Man> = shown.flat_map(pages).collect();
    all.push(Man::new(command.clone()));
    all
}

/// The files that `generate man -o` writes.
pub fn page_names() -> Vec<String> {
    pages(&built()).iter().map(Man::get_filename).collect()
}

/// Prints a manual page, or writes all of them.
pub fn man(context: &mut Context<'_>, args: &ManArgs) -> Result<(), Error> {
    let cli = built();
    if let Some(folder) = &args.output {
        let write = || {
            std::fs::create_dir_all(folder)?;
            pages(&cli).iter().try_for_each(|page| page.generate_to(folder).map(|_| ()))
        };
        return write().map_err(|source| WriteError { path: folder.clone(), source }.into());
    }
    let page = match &args.command {
        None => &cli,
        Some(name) => cli.find_subcommand(name).ok_or_else(|| {
            let names = cli.get_subcommands().map(clap::Command::get_name);
            PlanError::unknown("command", name, names)
        })?,
    };
    Man::new(page.clone()).render(context.out)?;
    Ok(context.out.flush()?)
}
