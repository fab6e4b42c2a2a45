//! `rtbench merge`.

use std::path::PathBuf;

use clap::Args;

use crate::args::exports::ExportArgs;

/// `rtbench merge`.
#[derive(Debug, Clone, Args)]
pub struct MergeArgs {
    /// The parts: results.json files, or the folders of `run --shard I/N -o DIR`, in any order
    #[arg(value_name = "DIR|FILE", required = true)]
    pub parts: Vec<PathBuf>,
    /// Join parts of different machines: their ratios and counters can be compared, not their times
    #[arg(long)]
    pub mixed_machines: bool,
    /// What to write.
    #[command(flatten)]
    pub exports: ExportArgs,
}
