//! `rtbench scenes`.

use clap::{Args, Subcommand};

use crate::args::parsers::scene_name;

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
