//! `rtbench run` and `rtbench sweep`.

use std::path::PathBuf;
use std::time::Duration;

use clap::Args;

use crate::args::measuring::{ExportArgs, PluginArgs, RatioArgs, TableArgs};
use crate::args::parsers::{choice, scene_name};
use measurement::plan::error::PlanError;
use measurement::rays::order::Orders;
use measurement::settings::quantity::{bytes, duration};
use measurement::settings::{Lights, MeasuringSettings, RunSettings};
use studies::sweep::SweepSettings;
use studies::sweep::sizes::SizeSettings;
use studies::sweep::sizes::Sizes;
use studies::sweep::values::Range;

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
    #[arg(long, help_heading = "Measuring", value_name = "TIME", value_parser = duration)]
    pub pass_limit: Option<Duration>,
    /// Memory limit of a structure; rows above it are shown as `out of memory` [default: half of
    /// the machine's memory, or of the control group's limit if that is less]
    #[arg(long, help_heading = "Measuring", value_name = "BYTES", value_parser = bytes)]
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

/// The range `0.1..100`, of nine values, or `0.1..100:13`.
fn range(values: &[String]) -> Option<Range> {
    let [only] = values else { return None };
    let (from, rest) = only.split_once("..")?;
    let (to, steps) = rest.split_once(':').unwrap_or((rest, "9"));
    let steps = steps.parse().ok().filter(|steps| (2..=1000).contains(steps))?;
    Some(Range { from: from.parse().ok()?, to: to.parse().ok()?, steps })
}

#[derive(Debug, Clone, Args)]
pub struct SweepArgs {
    /// Scenes, scene sets or scene files; with --sizes one generated scene: balls, tree-tess, hare
    #[arg(value_name = "SCENE|SET", required = true, value_parser = scene_name())]
    pub scenes: Vec<String>,
    /// Structure to vary, with its other settings if any: uniform-grid:resolution=woo; with
    /// --sizes, structures and occluders to measure [default: all, with their defaults]
    #[arg(short, long, alias = "structure", value_name = "STRUCTURE", value_delimiter = ',')]
    #[arg(required_unless_present = "sizes")]
    pub structures: Vec<String>,
    /// Parameter to vary
    #[arg(short, long, value_name = "PARAM", required_unless_present = "sizes")]
    pub parameter: Option<String>,
    /// Values of the parameter: none,array,hash; or a range of nine numbers, equal ratios apart:
    /// 0.1..100; of 13: 0.1..100:13
    #[arg(long, value_name = "A,B,...|A..B[:N]", value_delimiter = ',')]
    #[arg(required_unless_present = "sizes")]
    pub values: Vec<String>,
    /// Vary the number of primitives instead of a parameter: 1e3..1e7, by factors of ten, or
    /// 1k,20k,1M; for each, the nearest size that the scene has
    #[arg(long, value_name = "FROM..TO|N,N,...", value_parser = Sizes::parse,
          conflicts_with_all = ["parameter", "values"])]
    pub sizes: Option<Sizes>,
    /// Time limit of a build; slower rows are not measured, nor tried at larger sizes
    #[arg(long, value_name = "TIME", default_value = "60s", requires = "sizes",
          value_parser = duration)]
    pub time_limit: Duration,
    /// Memory limit of a structure; rows above it are shown as `out of memory` [default: half of
    /// the machine's memory, or of the control group's limit if that is less]; with --sizes, limit
    /// of a process that loads the scene and builds one row, shown as `over limit` [default: 8GiB]
    #[arg(long, value_name = "BYTES", value_parser = bytes)]
    pub max_memory: Option<u64>,
    /// Write results.json, sweep.csv, sweep.md and sweep.svg to DIR; with --sizes also slopes.csv
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    #[command(flatten)]
    pub measuring: RatioArgs,
}

impl SweepArgs {
    /// The sweep over a parameter that was typed.
    pub fn settings(&self) -> Result<SweepSettings, PlanError> {
        let [structure] = &self.structures[..] else {
            return Err(PlanError::Malformed {
                text: self.structures.join(","),
                expected: "one structure, whose parameter is swept",
            });
        };
        Ok(SweepSettings {
            scenes: self.scenes.clone(),
            structure: structure.clone(),
            parameter: self.parameter.clone().unwrap_or_default(),
            values: self.values.clone(),
            range: range(&self.values),
            measuring: self.measuring(),
        })
    }

    /// The sweep over sizes that was typed.
    pub fn size_settings(&self, sizes: &Sizes) -> Result<SizeSettings, PlanError> {
        let [scene] = &self.scenes[..] else {
            return Err(PlanError::Malformed {
                text: self.scenes.join(" "),
                expected: "one generated scene, like balls",
            });
        };
        Ok(SizeSettings {
            scene: scene.clone(),
            sizes: sizes.clone(),
            structures: self.structures.clone(),
            measuring: self.measuring(),
            time_limit: self.time_limit,
        })
    }

    fn measuring(&self) -> MeasuringSettings {
        MeasuringSettings { max_memory: self.max_memory, ..self.measuring.settings() }
    }
}
