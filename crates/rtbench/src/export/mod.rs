//! Results as files and tables, one format a file.

pub mod bencher;
pub mod created;
pub mod csv;
pub mod files;
pub mod github_action_benchmark;
pub mod json;
pub mod kind_tables;
pub mod markdown;
pub mod measures;
pub mod numbers;
pub mod scale_csv;
pub mod scale_plot;
pub mod scale_table;
pub mod svg_plot;
pub mod sweep_csv;
pub mod sweep_plot;
pub mod sweep_table;
pub mod table;
pub mod text;

use std::path::PathBuf;

use crate::args::ExportArgs;
use crate::error::Error;
use crate::record::RunRecord;

/// A format that the record of a run is written in.
#[derive(Debug, Clone, Copy)]
pub struct Exporter {
    /// Where the command line wants it.
    pub path: fn(&ExportArgs) -> Option<&PathBuf>,
    /// The file's name in the folder of `-o`, if it is written there.
    pub in_folder: Option<&'static str>,
    /// The text of what is finished so far.
    pub to_string: fn(&RunRecord) -> Result<String, Error>,
}

/// All formats.
pub static EXPORTERS: [Exporter; 6] = [
    exporter(|args| args.export_csv.as_ref(), Some("results.csv"), csv::to_string),
    exporter(|args| args.export_markdown.as_ref(), Some("results.md"), markdown::exported),
    exporter(|args| args.export_json.as_ref(), Some("results.json"), json::to_string),
    exporter(|args| args.export_github_smaller.as_ref(), None, github_action_benchmark::smaller),
    exporter(|args| args.export_github_bigger.as_ref(), None, github_action_benchmark::bigger),
    exporter(|args| args.export_bencher.as_ref(), None, bencher::to_string),
];

const fn exporter(
    path: fn(&ExportArgs) -> Option<&PathBuf>,
    in_folder: Option<&'static str>,
    to_string: fn(&RunRecord) -> Result<String, Error>,
) -> Exporter {
    Exporter { path, in_folder, to_string }
}
