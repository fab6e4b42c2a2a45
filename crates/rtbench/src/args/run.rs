//! `rtbench run`.

use std::path::PathBuf;

use std::time::Duration;

use clap::Args;
use measurement::rays::order::Orders;
use measurement::settings::{Lights, MeasuringSettings, RunSettings, quantity};

use crate::args::measuring::{ExportArgs, PluginArgs, RatioArgs, TableArgs};
use crate::args::parsers::{choice, scene_name};

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
    pub measuring: RatioArgs,
    /// Order in which rays are issued to rows
    #[arg(long, help_heading = "Measuring", value_parser = choice::<Orders>(),
          default_value = Orders::default().name())]
    pub order: Orders,
    /// Lights that get shadow rays
    #[arg(long, help_heading = "Measuring", value_parser = choice::<Lights>(),
          default_value = Lights::default().name())]
    pub lights: Lights,
    /// Longest pass over the rays; slower rows are timed on a sample of them [default: 200ms, 30ms
    /// with --quick]
    #[arg(long, help_heading = "Measuring", value_name = "TIME", value_parser = quantity::duration)]
    pub pass_limit: Option<Duration>,
    /// Memory limit of a structure; rows above it are shown as `out of memory` [default: half of
    /// the machine's memory, or of the control group's limit if that is less]
    #[arg(long, help_heading = "Measuring", value_name = "BYTES", value_parser = quantity::bytes)]
    pub max_memory: Option<u64>,
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
                order: self.order,
                lights: self.lights,
                pass_limit: self.pass_limit,
                max_memory: self.max_memory,
                ..self.measuring.settings()
            },
            shard: self.shard,
            by_kind: self.by_kind,
            processes: self.processes,
        }
    }
}
