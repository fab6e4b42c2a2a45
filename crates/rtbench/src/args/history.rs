//! `rtbench history`.

use std::path::PathBuf;

use clap::Args;

#[derive(Debug, Clone, Args)]
pub struct HistoryArgs {
    /// Folders of `rtbench run -o`, or folders of such folders
    #[arg(value_name = "DIR", required = true)]
    pub folders: Vec<PathBuf>,
    /// The folder that the site goes into
    #[arg(short, long, value_name = "SITE")]
    pub output: PathBuf,
    /// The repository of the commits: runs are put in the order of their commits, and subjects are shown
    #[arg(long, value_name = "DIR")]
    pub repository: Option<PathBuf>,
    /// Probability that a series without a change is said to have one
    #[arg(long, value_name = "P", default_value_t = 0.001, value_parser = probability)]
    pub significance: f64,
    /// Seed of the permutation tests
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
}

/// A probability that a permutation test can tell from 0.
fn probability(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(p) if (0.0001..=0.5).contains(&p) => Ok(p),
        _ => Err("expected a probability from 0.0001 to 0.5".into()),
    }
}
