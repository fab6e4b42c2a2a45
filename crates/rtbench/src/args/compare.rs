//! `rtbench compare`.

use std::path::PathBuf;

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
    /// Only what changed, in either direction, by more than this many percent
    #[arg(short, long, value_name = "PCT", value_parser = percent)]
    pub threshold: Option<f64>,
    /// Equivalence margin in percent: a ratio whose interval lies within it is no difference
    #[arg(long, value_name = "PCT", value_parser = percent, default_value = "5")]
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

/// Percent as typed: `5`, `2.5%`.
fn percent(text: &str) -> Result<f64, String> {
    let number = text.strip_suffix('%').unwrap_or(text).trim();
    let is_valid = |x: &f64| x.is_finite() && *x >= 0.0;
    let expected = || "expected percent from 0: 5, 2.5%".to_owned();
    number.parse().ok().filter(is_valid).ok_or_else(expected)
}
