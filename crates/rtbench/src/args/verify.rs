//! `rtbench verify`.

use std::path::PathBuf;
use std::time::Duration;

use clap::Args;

use crate::args::plugins::PluginArgs;

#[derive(Debug, Clone, Args)]
pub struct VerifyArgs {
    /// Cases or groups of cases: G1,grid [default: all]
    #[arg(long, value_name = "CASE|GROUP", value_delimiter = ',')]
    pub cases: Vec<String>,
    /// Structures as for `run` [default: all with all their variants, and the negative control]
    #[arg(short, long, alias = "structure", value_name = "STRUCTURE", value_delimiter = ',')]
    pub structures: Vec<String>,
    /// Also check further settings of these structures, which otherwise only tests cover
    #[arg(long)]
    pub also_tested: bool,
    /// Rays per case and precision; the default takes about 5 minutes of processor time
    #[arg(long, value_name = "N", default_value_t = 5000,
          value_parser = measurement::settings::quantity::count(1..=100_000_000))]
    pub rays: u32,
    /// Seed of scenes and rays
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
    /// Number of threads [default: all]
    #[arg(short = 'j', long, value_name = "N",
          value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// Stop after this time: results so far are printed and written, marked as incomplete, with
    /// exit code 5 if nothing is wrong; Ctrl-C does the same, with 130
    #[arg(long, value_name = "TIME", value_parser = measurement::settings::duration::parse)]
    pub time_limit: Option<Duration>,
    /// Repeat one trial, given by a line that an earlier run printed
    #[arg(long, value_name = "LINE")]
    pub replay: Option<String>,
    /// Reduce the first failure of each structure, case and precision to the fewest triangles and
    /// one ray, and write it to DIR: OBJ, rays for `trace`, and a C program over rtbench.h
    #[arg(long, value_name = "DIR")]
    pub shrink: Option<PathBuf>,
    /// Write one CSV row per case, precision and structure, rewritten after each case
    #[arg(long, value_name = "FILE")]
    pub export_csv: Option<PathBuf>,
    /// Write everything as JSON, rewritten after each case
    #[arg(long, value_name = "FILE")]
    pub export_json: Option<PathBuf>,
    #[command(flatten)]
    pub plugins: PluginArgs,
}
