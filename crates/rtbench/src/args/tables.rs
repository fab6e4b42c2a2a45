//! How tables of a run are printed.

use std::path::PathBuf;

use crate::args::parsers::choice;
use clap::Args;
use clap::builder::TypedValueParser;
use measurement::settings::choice::Choice;
use presentation::text::Screen;
use regex_lite::Regex;
use studies::run::view::{Columns, Sort, TableColumn, View};

/// Format of printed tables of a run; files have all columns and the order of the registry.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Tables")]
pub struct TableArgs {
    /// Order of the printed rows
    #[arg(long, value_parser = choice::<Sort>(), default_value = Sort::default().as_typed())]
    pub sort: Sort,
    /// Print all columns [default: those that fit the terminal, or 120 characters]
    #[arg(long, conflicts_with = "columns")]
    pub wide: bool,
    /// Print these columns: ratio, build, trace, image, memory, primary, shadow, second, diffuse,
    /// rays, n_it, ..., verdict
    #[arg(long, value_name = "COLUMN", value_delimiter = ',', value_parser = column())]
    pub columns: Vec<TableColumn>,
}

fn column() -> impl TypedValueParser<Value = TableColumn> {
    clap::builder::NonEmptyStringValueParser::new().try_map(|name| TableColumn::named(&name))
}

impl TableArgs {
    /// Format of tables on a screen.
    pub fn view(&self, screen: Screen) -> View {
        let columns = match &self.columns[..] {
            [] if self.wide => Columns::All,
            [] => Columns::Fitting,
            named => Columns::Named(named.to_vec()),
        };
        let screen = Screen { is_wide: self.wide, ..screen };
        View { sort: self.sort, columns, screen }
    }
}

/// Outputs of a run. `-` is standard output, which then has no tables.
#[derive(Debug, Clone, Default, Args)]
#[group(id = "exports", multiple = true)]
#[command(next_help_heading = "Files")]
pub struct ExportArgs {
    /// Write one CSV row per scene, structure and setting; - is standard output, instead of the
    /// tables
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
    /// Write times, ratios, counters and rays per second in Bencher Metric Format; or -
    #[arg(long, value_name = "FILE")]
    pub export_bencher: Option<PathBuf>,
    /// Write to the three formats above only series that this regular expression finds in `SCENE:
    /// STRUCTURE SETTINGS / NAME`: 'teapot: (kd-tree|wide-bvh) / (build|trace)'
    #[arg(long, value_name = "REGEX", value_parser = Regex::new)]
    pub export_select: Option<Regex>,
    /// Write results.csv, results.md and results.json to DIR; `run` also writes run.jsonl, to
    /// resume from
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
}
