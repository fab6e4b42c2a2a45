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
    /// Structures and occluders, each with its settings if any: uniform-grid:resolution=woo:density=1,
    /// or `all` [default: all with all their variants]
    #[arg(short, long, value_name = "STRUCTURE", value_delimiter = ',')]
    pub structures: Vec<String>,
    /// Overrides a default of a structure: uniform-grid.density=4
    #[arg(long = "set", value_name = "STRUCTURE.PARAM=VALUE")]
    pub overrides: Vec<String>,
    #[command(flatten)]
    pub measuring: MeasuringArgs,
    #[command(flatten)]
    pub issue: IssueArgs,
    #[command(flatten)]
    pub plugins: PluginArgs,
    /// How much memory a structure may take.
    #[command(flatten)]
    pub memory: MemoryArgs,
    /// Measure one part of the table only: 2/8 is the second of eight; `rtbench merge` joins them
    #[arg(long, value_name = "I/N", value_parser = measurement::settings::shard::Shard::parse)]
    pub shard: Option<measurement::settings::shard::Shard>,
    /// Build and time each scene in that many processes, and take intervals over both levels; every
    /// second process runs a copy of the program's file
    #[arg(long, value_name = "N", default_value_t = 1,
          value_parser = clap::value_parser!(u32).range(1..=RunSettings::MOST_PROCESSES.into()))]
    pub processes: u32,
    /// Also print ratios of each kind of ray, and the time to image of a million primary rays
    #[arg(long)]
    pub by_kind: bool,
    /// Take what is not said from that set, as a run of it alone does: its rays, sizes, rows
    #[arg(long = "as", value_name = "SET")]
    pub as_set: Option<String>,
    #[command(flatten)]
    pub tables: TableArgs,
    #[command(flatten)]
    pub exports: ExportArgs,
    /// Finish the run that was begun with -o DIR: scenes that are finished are not measured again,
    /// and other files than those in DIR are written where this command line says so
    #[arg(long, value_name = "DIR", conflicts_with_all = ["scenes", "structures", "overrides",
          "rays", "rounds", "time_budget", "quick", "threads", "seed", "reference", "precision",
          "size", "shard", "order", "lights", "by_kind", "processes", "pass_limit", "as_set", "max_memory", "output"])]
    pub resume: Option<PathBuf>,
}

impl RunArgs {
    /// What was typed, but for the files to write.
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
