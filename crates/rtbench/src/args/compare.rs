//! `rtbench compare`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use crate::args::parsers::percent;

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
    /// Write one CSV row per scene, structure and metric
    #[arg(long, value_name = "FILE")]
    pub export_csv: Option<PathBuf>,
    /// Write the tables in Markdown
    #[arg(long, value_name = "FILE")]
    pub export_markdown: Option<PathBuf>,
    /// Write everything as JSON
    #[arg(long, value_name = "FILE")]
    pub export_json: Option<PathBuf>,
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
