//! What a run can write: one option a format, see [`crate::exports::EXPORTERS`].

use std::path::PathBuf;

use clap::Args;
use regex_lite::Regex;

/// Outputs of a run. `-` is standard output, which then has no tables.
#[derive(Debug, Clone, Default, Args)]
#[group(id = "exports", multiple = true)]
#[command(next_help_heading = "Files")]
pub struct ExportArgs {
    /// Write one CSV row per scene, structure and setting; - is standard output, instead of the tables
    #[arg(long, value_name = "FILE")]
    pub export_csv: Option<PathBuf>,
    /// Write the tables in Markdown; or -
    #[arg(long, value_name = "FILE")]
    pub export_markdown: Option<PathBuf>,
    /// Write everything, raw samples too, as JSON; or -
    #[arg(long, value_name = "FILE")]
    pub export_json: Option<PathBuf>,
    /// Write times, ratios and counters for github-action-benchmark (customSmallerIsBetter); or -
    #[arg(long, value_name = "FILE")]
    pub export_github_smaller: Option<PathBuf>,
    /// Write rays per second for github-action-benchmark (customBiggerIsBetter); or -
    #[arg(long, value_name = "FILE")]
    pub export_github_bigger: Option<PathBuf>,
    /// Write all of these in Bencher Metric Format; or -
    #[arg(long, value_name = "FILE")]
    pub export_bencher: Option<PathBuf>,
    /// Of the three formats above only the series that this regular expression finds in
    /// `SCENE: STRUCTURE SETTINGS / NAME`: 'teapot: (kd-tree|wide-bvh) / (build|trace)'
    #[arg(long, value_name = "REGEX", value_parser = Regex::new)]
    pub export_select: Option<Regex>,
    /// Write results.csv, results.md and results.json there; `run` also run.jsonl, to resume from
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
}
