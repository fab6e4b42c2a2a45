//! `rtbench merge`.

use std::path::PathBuf;

use clap::Args;

use crate::args::exports::ExportArgs;
use crate::args::tables::TableArgs;

#[derive(Debug, Clone, Args)]
pub struct MergeArgs {
    /// The parts: results.json files, or the folders of `run --shard I/N -o DIR`, in any order; with
    /// --machines, whole runs
    #[arg(value_name = "DIR|FILE", required = true)]
    pub parts: Vec<PathBuf>,
    /// Join parts of different machines: their ratios and counters can be compared, not their times
    #[arg(long)]
    pub mixed_machines: bool,
    /// The same run on several machines: each ratio on each of them, and its range. -o writes
    /// machines.json, machines.csv and machines.md
    #[arg(long, conflicts_with_all = ["mixed_machines", "export_github_smaller",
          "export_github_bigger", "export_bencher"])]
    pub machines: bool,
    #[command(flatten)]
    pub tables: TableArgs,
    #[command(flatten)]
    pub exports: ExportArgs,
}
