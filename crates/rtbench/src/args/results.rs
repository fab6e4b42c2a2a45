//! Arguments of the commands over results: `compare`, `merge`, `report`, `history`, `baseline`.

use crate::args::measuring::{ExportArgs, TableArgs};
use crate::args::parsers::percent;
use crate::args::run::RunArgs;
use clap::{Args, Subcommand, ValueEnum};
use std::path::PathBuf;

#[derive(Debug, Clone, Args)]
pub struct CompareArgs {
    /// Results: the JSON file of a run, or the folder of `run -o`; all others are compared with the
    /// first
    #[arg(value_name = "RESULTS", required = true, num_args = 2..)]
    pub results: Vec<PathBuf>,
    /// Compare only what this regular expression finds in `SCENE/STRUCTURE SETTINGS/METRIC`
    #[arg(short, long, value_name = "REGEX")]
    pub filter: Option<String>,
    /// Print only changes larger than this, in either direction: 5%
    #[arg(short, long, value_name = "PERCENT", value_parser = percent)]
    pub threshold: Option<f64>,
    /// Equivalence margin: a ratio whose interval lies within it counts as equal
    // smaller differences are those of where code and memory lie, and what `check` lets pass
    #[arg(long, value_name = "PERCENT", value_parser = percent, default_value = "5%")]
    pub margin: f64,
    /// Compare row OLD of the first results with row NEW of the others; the name of a structure
    /// stands for all its rows
    #[arg(long = "match", value_name = "OLD=NEW")]
    pub matches: Vec<String>,
    /// Print these metrics, or `all`, equal or not [default: build, trace, ratio, and exact metrics
    /// that differ]
    #[arg(short, long, value_name = "METRIC", value_delimiter = ',')]
    pub metrics: Vec<String>,
    /// Compare results that are not comparable; the reasons are printed with them
    #[arg(long)]
    pub force: bool,
    /// Format of the output
    #[arg(long, value_enum, default_value_t = CompareFormat::Text)]
    pub format: CompareFormat,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum CompareFormat {
    /// Plain text
    Text,
    /// Markdown, for pages and pull requests
    Markdown,
    /// CSV, for spreadsheets
    Csv,
    /// JSON, for programs
    Json,
}

#[derive(Debug, Clone, Args)]
pub struct MergeArgs {
    /// Shards to merge: results.json files, or folders of `run --shard I/N -o DIR`, in any order
    #[arg(value_name = "DIR|FILE", required = true)]
    pub parts: Vec<PathBuf>,
    /// Merge shards of different machines; ratios and counters stay comparable, times do not
    #[arg(long)]
    pub mixed_machines: bool,
    #[command(flatten)]
    pub exports: ExportArgs,
}

#[derive(Debug, Clone, Args)]
pub struct ReportArgs {
    /// Folder of `rtbench run -o DIR`; results of other commands in it are shown too. Several
    /// folders: runs, or machines, side by side
    #[arg(value_name = "DIR", required = true)]
    pub folders: Vec<PathBuf>,
    /// File to write the page to, `-` for stdout [default: DIR/report.html; report.html for several
    /// folders]
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// Also write each plot of the page as an SVG file
    #[arg(long, value_name = "DIR")]
    pub plots: Option<PathBuf>,
    /// Leave out pictures of scenes (otherwise those missing in DIR/pictures are rendered)
    #[arg(long)]
    pub no_pictures: bool,
}

#[derive(Debug, Clone, Args)]
pub struct HistoryArgs {
    /// Folders of `rtbench run -o`, or folders of such folders
    #[arg(value_name = "DIR", required = true)]
    pub folders: Vec<PathBuf>,
    /// Folder to write the site to
    #[arg(short, long, value_name = "SITE")]
    pub output: PathBuf,
    /// Git repository of the commits, to put runs in the order of commits and to show their
    /// subjects
    #[arg(long, value_name = "DIR")]
    pub repository: Option<PathBuf>,
}

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
    /// The run to make [default: 15 rounds]
    #[command(flatten)]
    pub run: RunArgs,
}
