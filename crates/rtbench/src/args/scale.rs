//! `rtbench scale`.

use std::path::PathBuf;
use std::time::Duration;

use clap::Args;

use crate::args::measuring::MeasuringArgs;
use crate::args::parsers::{choice, scene_name};
use measurement::settings::Precision;
use measurement::settings::scale::ScaleSettings;
use measurement::settings::sizes::Sizes;

/// `rtbench scale`.
#[derive(Debug, Clone, Args)]
pub struct ScaleArgs {
    /// A generated scene, without a size: balls, tree-tess, hare
    #[arg(value_parser = scene_name())]
    pub scene: String,
    /// Numbers of primitives: 1e3..1e7, or 1k,20k,1M; the nearest size of the scene stands for each
    #[arg(long, value_name = "FROM..TO|N,N,...", default_value = "1e3..1e6",
          value_parser = Sizes::parse)]
    pub sizes: Sizes,
    /// How many sizes a factor of ten, where --sizes is a range
    #[arg(long, value_name = "N", default_value_t = 1,
          value_parser = clap::value_parser!(u32).range(1..=ScaleSettings::MOST_PER_DECADE.into()))]
    pub per_decade: u32,
    /// Structures and occluders, each with its settings if any, as for `run` [default: each at its
    /// defaults]
    #[arg(short, long, value_name = "STRUCTURE", value_delimiter = ',')]
    pub structures: Vec<String>,
    /// Overrides a default of a structure: uniform-grid.density=4
    #[arg(long = "set", value_name = "STRUCTURE.PARAM=VALUE")]
    pub overrides: Vec<String>,
    /// How to measure.
    #[command(flatten)]
    pub measuring: MeasuringArgs,
    /// Longest build; a row that takes longer is not measured, nor tried at larger sizes
    #[arg(long, value_name = "TIME", default_value = "60s", value_parser = measurement::settings::duration::parse)]
    pub time_limit: Duration,
    /// Most memory of a process that loads the scene and builds one row; the same holds
    #[arg(long, value_name = "BYTES", default_value = "8GiB", value_parser = measurement::settings::quantity::bytes)]
    pub max_memory: u64,
    /// What to write.
    #[command(flatten)]
    pub exports: ScaleExportArgs,
}

/// What `rtbench scale` writes.
#[derive(Debug, Clone, Args)]
pub struct ScaleExportArgs {
    /// Write results.json, scale.csv, slopes.csv, scale.md, scale.svg and the journal there; `run
    /// --resume DIR` goes on with it
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// Write one CSV row per size, structure and setting; - is standard output, instead of the tables
    #[arg(long, value_name = "FILE")]
    pub export_csv: Option<PathBuf>,
    /// Write one CSV row per slope; or -
    #[arg(long, value_name = "FILE")]
    pub export_slopes: Option<PathBuf>,
    /// Write plots, one panel a quantity; or -
    #[arg(long, value_name = "FILE")]
    pub export_svg: Option<PathBuf>,
    /// Write the tables in Markdown; or -
    #[arg(long, value_name = "FILE")]
    pub export_markdown: Option<PathBuf>,
    /// Write everything, raw samples too, as JSON; or -
    #[arg(long, value_name = "FILE")]
    pub export_json: Option<PathBuf>,
}

impl ScaleArgs {
    /// What was typed, but for the files to write.
    pub fn settings(&self) -> ScaleSettings {
        ScaleSettings {
            scene: self.scene.clone(),
            sizes: self.sizes.clone(),
            per_decade: self.per_decade,
            structures: self.structures.clone(),
            overrides: self.overrides.clone(),
            measuring: self.measuring.settings(),
            time_limit: self.time_limit,
            max_memory: self.max_memory,
        }
    }
}

/// `rtbench child build`: what [`measurement::rounds::trial`] starts.
#[derive(Debug, Clone, Args)]
pub struct TrialArgs {
    /// Scene
    #[arg(long, value_parser = scene_name())]
    pub scene: String,
    /// Structure with its settings
    #[arg(long)]
    pub row: String,
    /// Threads that build
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: u16,
    /// Arithmetic of primitives
    #[arg(long, value_parser = choice::<Precision>(),
          default_value = Precision::default().name())]
    pub precision: Precision,
}
