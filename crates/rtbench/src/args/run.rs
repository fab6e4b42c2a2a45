//! `rtbench run`.

use std::path::PathBuf;

use clap::Args;
use measurement::settings::{MeasuringSettings, RunSettings};

use crate::args::measuring::{IssueArgs, MeasuringArgs, MemoryArgs};
use crate::args::parsers::scene_name;
use crate::args::plugins::PluginArgs;
use crate::args::tables::ExportArgs;
use crate::args::tables::TableArgs;

#[derive(Debug, Clone, Args)]
pub struct RunArgs {
    /// Scenes, scene sets or scene files [default: the set `spd`]
    #[arg(value_name = "SCENE|SET", value_parser = scene_name())]
    pub scenes: Vec<String>,
    /// Structures and occluders, with settings if any: uniform-grid:resolution=woo:density=1, or
    /// `all` [default: all with all their variants]
    #[arg(short, long, alias = "structure", value_name = "STRUCTURE", value_delimiter = ',')]
    pub structures: Vec<String>,
    /// Override a default of a structure: uniform-grid.density=4
    #[arg(long = "set", value_name = "STRUCTURE.PARAM=VALUE")]
    pub overrides: Vec<String>,
    /// Measure one part of the table only: 2/8 is the second of eight; `rtbench merge` joins them
    #[arg(long, value_name = "I/N", value_parser = measurement::settings::shard::Shard::parse)]
    pub shard: Option<measurement::settings::shard::Shard>,
    /// Build and time each scene in this many processes; intervals cover both rounds and processes;
    /// every second process runs a copy of the program's file, to find the noise floor
    #[arg(long, value_name = "N", default_value_t = 1,
          value_parser = clap::value_parser!(u32).range(1..=RunSettings::MOST_PROCESSES.into()))]
    pub processes: u32,
    /// Also print ratios of each kind of ray, and the time to image of a million primary rays
    #[arg(long)]
    pub by_kind: bool,
    /// Use this set's defaults (rays, sizes, rows) for options not given
    #[arg(long = "as", value_name = "SET")]
    pub as_set: Option<String>,
    /// Resume the interrupted run in DIR: finished scenes are not measured again; exports outside
    /// DIR must be requested again
    #[arg(long, value_name = "DIR", conflicts_with_all = ["scenes", "structures", "overrides",
          "rays", "rounds", "time_budget", "quick", "threads", "seed", "reference", "precision",
          "size", "shard", "order", "lights", "by_kind", "processes", "pass_limit", "as_set", "max_memory", "output"])]
    pub resume: Option<PathBuf>,
    #[command(flatten)]
    pub measuring: MeasuringArgs,
    #[command(flatten)]
    pub issue: IssueArgs,
    #[command(flatten)]
    pub memory: MemoryArgs,
    #[command(flatten)]
    pub plugins: PluginArgs,
    #[command(flatten)]
    pub tables: TableArgs,
    #[command(flatten)]
    pub exports: ExportArgs,
}

impl RunArgs {
    /// The options, except for output files.
    pub fn settings(&self) -> RunSettings {
        RunSettings {
            scenes: self.scenes.clone(),
            structures: self.structures.clone(),
            overrides: self.overrides.clone(),
            measuring: MeasuringSettings {
                max_memory: self.memory.max_memory,
                ..self.issue.over(self.measuring.settings())
            },
            shard: self.shard,
            by_kind: self.by_kind,
            processes: self.processes,
        }
    }
}
