//! `rtbench bisect`.

use std::ffi::OsString;
use std::path::PathBuf;

use clap::Args;

use crate::args::check::percent;

/// `rtbench bisect`.
#[derive(Debug, Clone, Args)]
pub struct BisectArgs {
    /// A commit that is fast
    pub good: String,
    /// A later one that is slow
    pub bad: String,
    /// Rows of rtbench that became slower, `SCENE/STRUCTURE`, `SCENE/STRUCTURE SETTINGS/build`; with --binary
    /// the arguments of that program, which prints times as for `check --against`
    #[arg(last = true, value_name = "ROW", required_unless_present = "binary")]
    pub rows: Vec<OsString>,
    /// What builds a commit, in its folder
    #[arg(long, value_name = "CMD", default_value = "cargo build --release")]
    pub build: String,
    /// The program that the build leaves, from the commit's folder on [default: rtbench's own]
    #[arg(long, value_name = "PATH")]
    pub binary: Option<PathBuf>,
    /// The repository [default: the one of this folder]
    #[arg(long, value_name = "DIR", default_value = ".", hide_default_value = true)]
    pub repository: PathBuf,
    /// Turns of a process of each; twice and four times as many where times are uncertain [default: 15]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=10_000))]
    pub rounds: Option<u32>,
    /// A commit is bad where a time is certainly longer than the good one's by more than that, percent
    /// [default: 5]
    #[arg(short = 't', long, value_name = "PCT", value_parser = percent)]
    pub time_threshold: Option<f64>,
    /// Seed of orders and intervals
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
}
