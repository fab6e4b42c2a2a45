//! `rtbench list`, `scenes`, `doctor` and `generate`.

use std::path::PathBuf;

use crate::args::parsers::scene_name;
use clap::{Args, Subcommand, ValueEnum};
use clap_complete::Shell;

#[derive(Debug, Clone, Args)]
pub struct ListArgs {
    /// Subject of the list
    #[arg(value_enum)]
    pub what: ListSubject,
    /// List only entries of these names, in detail
    #[arg(value_name = "NAME")]
    pub names: Vec<String>,
    /// Format of the output: text or JSON
    #[arg(long, value_enum, default_value_t = Format::Text)]
    pub format: Format,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum ListSubject {
    /// Structures with their parameters
    Structures,
    /// Occluders, which answer shadow rays, with their parameters
    Occluders,
    /// Tracers, which make images, with their assumptions and the scenes they do not support
    Tracers,
    /// Scenes, with what they consist of
    Scenes,
    /// Scenes that move, for `animate`
    Animations,
    /// Sets of scenes, as `run` takes them
    Sets,
    /// Kinds of rays that rows are timed on
    Rays,
    /// Axes of `rtbench accuracy`, with their variants
    Axes,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Format {
    /// Plain text
    Text,
    /// JSON, for programs
    Json,
}

#[derive(Debug, Clone, Args)]
pub struct DoctorArgs {
    /// Format of the output: text or JSON
    #[arg(long, value_enum, default_value_t = Format::Text)]
    pub format: Format,
}

#[derive(Debug, Clone, Subcommand)]
pub enum ScenesAction {
    /// Print what scenes consist of
    Info(SceneNames),
    /// Load scenes and report all their errors
    Validate(SceneNames),
    /// Download scenes that are published in packages
    Fetch(SceneNames),
}

#[derive(Debug, Clone, Args)]
pub struct SceneNames {
    /// Scenes, sets or files [default: all scenes]
    #[arg(value_name = "NAME", value_parser = scene_name())]
    pub names: Vec<String>,
}

#[derive(Debug, Clone, Subcommand)]
pub enum GeneratedText {
    /// The JSON schemas of output files and scene files
    Schema {
        /// Format whose schema is printed
        #[arg(value_enum, default_value_t = SchemaOf::RunRecord)]
        what: SchemaOf,
    },
    /// Completions for a shell
    #[command(after_help = "Examples:\n  rtbench generate completions bash")]
    Completions {
        /// Shell to complete for
        #[arg(value_enum)]
        shell: Shell,
    },
    /// The manual page, or the pages of all commands
    Man(ManArgs),
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum SchemaOf {
    /// results.json
    RunRecord,
    /// Output of --export-github-smaller and --export-github-bigger
    GithubActionBenchmark,
    /// Output of --export-bencher
    BencherMetricFormat,
    /// JSON scene files, which are read
    Scene,
}

#[derive(Debug, Clone, Args)]
pub struct ManArgs {
    /// Command whose page is printed [default: rtbench]
    #[arg(value_name = "COMMAND", conflicts_with = "output")]
    pub command: Option<String>,
    /// Write the pages of all commands into this folder
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
}
