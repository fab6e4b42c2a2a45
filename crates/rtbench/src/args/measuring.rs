//! Options that commands share: what is measured, plugins, tables, time series.

use crate::args::parsers::{choice, threads};
use clap::Args;
use clap::builder::TypedValueParser;
use measurement::settings::choice::Choice;
use measurement::settings::quantity::{count, duration};
use measurement::settings::{MeasuringSettings, Precision};
use presentation::text::Screen;
use regex_lite::Regex;
use std::ffi::OsString;
use std::path::PathBuf;
use std::time::Duration;
use studies::run::view::{Columns, Sort, TableColumn, View};

/// Options of all commands that measure.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Measuring")]
pub struct MeasuringArgs {
    /// Kinds of rays to trace [default: all]
    #[arg(long, value_name = "KIND", value_delimiter = ',')]
    pub rays: Vec<String>,
    /// Rounds; each measures every row once [default: 5, 3 with --quick]
    #[arg(long, value_name = "N", value_parser = count(1..=MeasuringSettings::MOST_ROUNDS))]
    pub rounds: Option<u32>,
    /// Use small images and few rounds, for a first look
    #[arg(long)]
    pub quick: bool,
    /// Number of threads that build and trace
    #[arg(short = 'j', long, value_name = "N", default_value_t = 1, value_parser = threads())]
    pub threads: u16,
    /// Seed of schedules, samples and intervals
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
    /// Floating-point precision of primitives and rays
    #[arg(long, value_parser = choice::<Precision>(), default_value = Precision::default().name())]
    pub precision: Precision,
    /// Width and height of the image [default: 128, 48 with --quick, unless the set has its own]
    #[arg(long, value_name = "PIXELS", value_parser = clap::value_parser!(u32).range(1..=MeasuringSettings::LARGEST_SIZE.into()))]
    pub size: Option<u32>,
}

impl MeasuringArgs {
    pub fn settings(&self) -> MeasuringSettings {
        MeasuringSettings {
            rays: self.rays.clone(),
            rounds: self.rounds,
            quick: self.quick,
            threads: self.threads,
            seed: self.seed,
            precision: self.precision,
            size: self.size,
            ..MeasuringSettings::default()
        }
    }
}

/// Options of commands that measure rows against a reference, for as long as is said.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Measuring")]
pub struct RatioArgs {
    #[command(flatten)]
    pub measuring: MeasuringArgs,
    /// Keep measuring until this time has elapsed, all scenes together: 60s, 1.5m, 2h30m
    #[arg(long, value_name = "TIME", conflicts_with = "rounds", value_parser = duration)]
    pub time_budget: Option<Duration>,
    /// Reference row of ratios [default: obvhs-cwbvh, else obvhs-cwbvh adapter=robust, else the
    /// first row]
    #[arg(long, value_name = "STRUCTURE")]
    pub reference: Option<String>,
}

impl RatioArgs {
    pub fn settings(&self) -> MeasuringSettings {
        MeasuringSettings {
            time_budget: self.time_budget,
            reference: self.reference.clone(),
            ..self.measuring.settings()
        }
    }
}

/// Format of printed tables of a run; files have all columns and the order of the registry.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Tables")]
pub struct TableArgs {
    /// Order of the printed rows
    #[arg(long, value_parser = choice::<Sort>(), default_value = Sort::default().as_typed())]
    pub sort: Sort,
    /// Print these columns: ratio, build, trace, image, memory, primary, shadow, second, diffuse,
    /// rays, n_it, ..., verdict [default: those that fit the terminal, or 120 characters]
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
            [] => Columns::Fitting,
            named => Columns::Named(named.to_vec()),
        };
        View { sort: self.sort, columns, screen }
    }
}

/// Files of a run.
#[derive(Debug, Clone, Default, Args)]
#[group(id = "exports", multiple = true)]
#[command(next_help_heading = "Files")]
pub struct ExportArgs {
    /// Write results.csv, results.md and results.json to DIR; `run` also writes run.jsonl, to
    /// resume from
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// Write times, ratios and counters for github-action-benchmark (customSmallerIsBetter)
    #[arg(long, value_name = "FILE")]
    pub export_github_smaller: Option<PathBuf>,
    /// Write rays per second for github-action-benchmark (customBiggerIsBetter)
    #[arg(long, value_name = "FILE")]
    pub export_github_bigger: Option<PathBuf>,
    /// Write times, ratios, counters and rays per second in Bencher Metric Format
    #[arg(long, value_name = "FILE")]
    pub export_bencher: Option<PathBuf>,
    /// Write to the three formats above only series that this regular expression finds in `SCENE:
    /// STRUCTURE SETTINGS / NAME`: 'teapot: (kd-tree|wide-bvh) / (build|trace)'
    #[arg(long, value_name = "REGEX", value_parser = Regex::new)]
    pub export_select: Option<Regex>,
}

/// Plugins, and how they run.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Plugins")]
pub struct PluginArgs {
    /// Measure a structure from this shared library (see rtbench.h) as an extra row
    #[arg(long, value_name = "FILE")]
    pub plugin: Vec<PathBuf>,
    /// Load plugins in-process (a plugin crash aborts the run)
    #[arg(long, requires = "plugin")]
    pub in_process: bool,
    /// Time limit of a plugin's build, and of each of its calls that answer rays
    #[arg(long, value_name = "TIME", default_value = "60s", requires = "plugin",
          value_parser = duration)]
    pub plugin_limit: Duration,
}

impl PluginArgs {
    /// Arguments that pass the plugins to another process of this program; empty without plugins.
    pub fn arguments(&self) -> Vec<OsString> {
        self.arguments_for(&self.plugin)
    }

    /// The same settings with other files.
    pub fn arguments_for(&self, files: &[PathBuf]) -> Vec<OsString> {
        let files = files.iter().flat_map(|file| ["--plugin".into(), file.clone().into()]);
        let mut arguments: Vec<OsString> = files.collect();
        if !arguments.is_empty() {
            let limit = format!("{}ms", self.plugin_limit.as_millis().max(1));
            arguments.extend(["--plugin-limit".into(), limit.into()]);
            arguments.extend(self.in_process.then(|| "--in-process".into()));
        }
        arguments
    }
}

/// `rtbench child plugin`: what a run starts for each row of a plugin.
#[derive(Debug, Clone, Args)]
pub struct ServeArgs {
    /// Shared library of the plugin
    #[arg(long)]
    pub file: PathBuf,
    /// Address at which the run listens
    #[arg(long)]
    pub socket: PathBuf,
}
