//! `rtbench baseline`.

use std::path::PathBuf;

use clap::{Args, Subcommand};

use crate::args::run::RunArgs;
use crate::args::tables::TableArgs;

#[derive(Debug, Clone, Args)]
pub struct BaselineArgs {
    /// What to do with baselines.
    #[command(subcommand)]
    pub action: BaselineAction,
    /// Where they are kept.
    #[command(flatten)]
    pub folder: FolderArgs,
}

/// Where baselines are kept.
#[derive(Debug, Clone, Args)]
pub struct FolderArgs {
    /// Folder of the baselines [default: RTBENCH_BASELINES, or .rtbench/baselines]
    #[arg(long, value_name = "DIR", global = true)]
    pub baselines: Option<PathBuf>,
}

/// What to do with baselines.
#[derive(Debug, Clone, Subcommand)]
pub enum BaselineAction {
    /// Keep results under a name: those of an earlier run, or of one made now
    Save(Box<SaveArgs>),
    /// List what is kept
    List,
    /// Print the tables of one
    Show {
        /// Its name
        name: String,
        #[command(flatten)]
        tables: TableArgs,
    },
    /// Keep one under another name, too, in place of what had that name
    Promote {
        /// Its name
        name: String,
        /// The other name
        #[arg(value_name = "AS")]
        to: String,
    },
    /// Remove one
    Remove {
        /// Its name
        name: String,
    },
}

#[derive(Debug, Clone, Args)]
pub struct SaveArgs {
    /// Name: letters, digits, '.', '-' and '_'
    pub name: String,
    /// Take the results of an earlier run: its folder, or its results.json
    #[arg(long, value_name = "DIR|FILE", conflicts_with_all = ["scenes", "structures",
          "overrides", "plugin", "rays", "rounds", "processes", "time_budget", "quick", "seed", "reference", "size"])]
    pub from: Option<PathBuf>,
    /// Count instructions under valgrind, too, so that `check` finds what is 1% slower
    #[arg(long, conflicts_with = "plugin")]
    pub instructions: bool,
    /// Replace a baseline of that name
    #[arg(long)]
    pub force: bool,
    /// The run to make [default: 15 rounds]
    #[command(flatten)]
    pub run: RunArgs,
}
