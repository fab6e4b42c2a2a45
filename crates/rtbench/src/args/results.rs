//! Arguments of the commands over results: `compare`, `merge`, `report`, `history`.

use std::path::PathBuf;

use crate::args::parsers::percent;
use crate::args::tables::{ExportArgs, TableArgs};
use clap::{Args, ValueEnum};

/// `rtbench compare`.
#[derive(Debug, Clone, Args)]
pub struct CompareArgs {
    /// Results: the JSON file of a run, or the folder of `run -o`; the first is what all others are
    /// compared with
    #[arg(value_name = "RESULTS", required = true, num_args = 2..)]
    pub results: Vec<PathBuf>,
    /// Only what this regular expression finds in `SCENE/STRUCTURE SETTINGS/METRIC`
    #[arg(short, long, value_name = "REGEX")]
    pub filter: Option<String>,
    /// Only what changed, in either direction, by more than that: 5%
    #[arg(short, long, value_name = "PERCENT", value_parser = percent)]
    pub threshold: Option<f64>,
    /// Equivalence margin: a ratio whose interval lies within it is no difference
    #[arg(long, value_name = "PERCENT", value_parser = percent, default_value = "5%")]
    pub margin: f64,
    /// Compare a row that has another name now: OLD in the first results with NEW in the others; of a
    /// structure, all its rows
    #[arg(long = "match", value_name = "OLD=NEW")]
    pub matches: Vec<String>,
    /// Metrics, equal or not [default: build, trace, ratio, and every exact one that differs]
    #[arg(short, long, value_name = "METRIC", value_delimiter = ',')]
    pub metrics: Vec<String>,
    /// All metrics, equal or not
    #[arg(long, conflicts_with = "metrics")]
    pub all_metrics: bool,
    /// Compare what cannot be compared all the same; why it cannot stands with the results
    #[arg(long)]
    pub force: bool,
    /// The order of a scene's rows
    #[arg(long, value_enum, default_value_t = CompareSort::Record)]
    pub sort: CompareSort,
    /// How to print it
    #[arg(long, value_enum, default_value_t = CompareFormat::Text)]
    pub format: CompareFormat,
}

/// The order of a scene's rows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum CompareSort {
    /// As in the results
    Record,
    /// The largest change first
    Change,
}

/// How to print a comparison.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum CompareFormat {
    /// For reading
    Text,
    /// For pages and pull requests
    Markdown,
    /// For spreadsheets
    Csv,
    /// For programs
    Json,
}

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

#[derive(Debug, Clone, Args)]
pub struct ReportArgs {
    /// The folder that `rtbench run -o DIR` wrote; what other commands left there is shown too. Several: runs, or
    /// machines, side by side
    #[arg(value_name = "DIR", required = true)]
    pub folders: Vec<PathBuf>,
    /// Where the page goes, `-` for stdout [default: DIR/report.html; of several folders report.html]
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// Write each plot of the page as an SVG file, too
    #[arg(long, value_name = "DIR")]
    pub plots: Option<PathBuf>,
    /// No pictures of scenes: they are rendered where DIR/pictures has none of them
    #[arg(long)]
    pub no_pictures: bool,
}

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
}
