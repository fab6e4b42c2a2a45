//! `rtbench baseline`.

use std::path::PathBuf;

use clap::{Args, Subcommand};

use crate::args::run::RunArgs;
use crate::args::tables::TableArgs;

#[derive(Debug, Clone, Args)]
pub struct BaselineArgs {
    #[command(subcommand)]
    pub action: BaselineAction,
    #[command(flatten)]
    pub folder: FolderArgs,
}

#[derive(Debug, Clone, Args)]
pub struct FolderArgs {
    /// Folder of the baselines [default: RTBENCH_BASELINES, or .rtbench/baselines]
    #[arg(long, value_name = "DIR", global = true)]
    pub baselines: Option<PathBuf>,
}

#[derive(Debug, Clone, Subcommand)]
pub enum BaselineAction {
    /// Save results under a name: those of an earlier run, or of a run made now
    Save(Box<SaveArgs>),
    /// List saved baselines
    List,
    /// Print the tables of a baseline
    Show {
        /// Name of the baseline
        name: String,
        #[command(flatten)]
        tables: TableArgs,
    },
    /// Save a copy of a baseline under another name, replacing a baseline of that name
    Promote {
        /// Name of the baseline
        name: String,
        /// Name of the copy
        #[arg(value_name = "AS")]
        to: String,
    },
    /// Remove a baseline
    Remove {
        /// Name of the baseline
        name: String,
    },
}

#[derive(Debug, Clone, Args)]
pub struct SaveArgs {
    /// Name: letters, digits, '.', '-' and '_'
    pub name: String,
    /// Save the results of an earlier run: its folder, or its results.json
    #[arg(long, value_name = "DIR|FILE", conflicts_with_all = ["scenes", "structures",
          "overrides", "plugin", "rays", "rounds", "processes", "time_budget", "quick", "seed", "reference", "size"])]
    pub from: Option<PathBuf>,
    /// Also count instructions under valgrind, so that `check` finds rows that are 1% slower
    #[arg(long, conflicts_with = "plugin")]
    pub instructions: bool,
    /// Replace an existing baseline of that name
    #[arg(long)]
    pub force: bool,
    /// The run to make [default: 15 rounds]
    #[command(flatten)]
    pub run: RunArgs,
}
