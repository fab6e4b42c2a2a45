//! `rtbench schema`, `rtbench completions` and `rtbench man`: what is printed of the program itself.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use clap_complete::Shell;

#[derive(Debug, Clone, Args)]
pub struct SchemaArgs {
    /// Of which format
    #[arg(value_enum, default_value_t = SchemaOf::RunRecord)]
    pub what: SchemaOf,
}

/// The formats that have a schema.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum SchemaOf {
    /// results.json, what --export-json writes
    RunRecord,
    /// What --export-github-smaller and --export-github-bigger write
    GithubActionBenchmark,
    /// What --export-bencher writes
    BencherMetricFormat,
    /// JSON scene files, which are read
    Scene,
}

#[derive(Debug, Clone, Args)]
pub struct CompletionsArgs {
    /// The shell
    #[arg(value_enum)]
    pub shell: Shell,
}

#[derive(Debug, Clone, Args)]
pub struct ManArgs {
    /// The page of this command [default: that of rtbench]
    #[arg(value_name = "COMMAND", conflicts_with = "output")]
    pub command: Option<String>,
    /// Write the pages of all commands into this folder
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
}
