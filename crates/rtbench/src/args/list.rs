//! `rtbench list`.

use std::path::PathBuf;

use crate::args::parsers::scene_name;
use clap::{Args, Subcommand, ValueEnum};
use clap_complete::Shell;

#[derive(Debug, Clone, Args)]
pub struct ListArgs {
    /// What to list
    #[arg(value_enum)]
    pub what: ListSubject,
    /// Only those of these names
    #[arg(value_name = "NAME")]
    pub names: Vec<String>,
    /// As text or as JSON
    #[arg(long, value_enum, default_value_t = Format::Text)]
    pub format: Format,
}

/// What can be listed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum ListSubject {
    /// Structures with their parameters
    Structures,
    /// Occluders, which answer shadow rays, with their parameters
    Occluders,
    /// Tracers, which make images, with what each assumes and refuses
    Tracers,
    /// Scenes by name
    Scenes,
    /// Scenes that move, for `animate`
    Animations,
    /// Sets of scenes
    Sets,
    /// Kinds of rays
    Rays,
    /// Axes of accuracy
    Axes,
}

impl ListSubject {
    /// One of what is listed.
    pub fn singular(self) -> &'static str {
        match self {
            Self::Structures => "structure",
            Self::Occluders => "occluder",
            Self::Tracers => "tracer",
            Self::Scenes => "scene",
            Self::Animations => "animation",
            Self::Sets => "set",
            Self::Rays => "kind of rays",
            Self::Axes => "axis",
        }
    }
}

/// How to print a list.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Format {
    /// For reading
    Text,
    /// For programs
    Json,
}

#[derive(Debug, Clone, Args)]
pub struct DoctorArgs {
    /// As text or as JSON
    #[arg(long, value_enum, default_value_t = Format::Text)]
    pub format: Format,
}

#[derive(Debug, Clone, Args)]
pub struct ScenesArgs {
    /// What to do with them.
    #[command(subcommand)]
    pub action: ScenesAction,
}

/// What to do with scenes.
#[derive(Debug, Clone, Subcommand)]
pub enum ScenesAction {
    /// Say what scenes consist of
    Info(SceneNames),
    /// Load scenes and report everything that is wrong with them
    Validate(SceneNames),
    /// Bring scenes that come inside packages to this machine
    Fetch(SceneNames),
}

/// Names of scenes.
#[derive(Debug, Clone, Args)]
pub struct SceneNames {
    /// Scenes, sets or files [default: all scenes]
    #[arg(value_name = "NAME", value_parser = scene_name())]
    pub names: Vec<String>,
}

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
