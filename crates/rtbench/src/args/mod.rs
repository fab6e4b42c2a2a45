//! The command line as typed: syntax only. What it means is decided in [`measurement::plan`].

mod accuracy;
mod baseline;
mod check;
mod compare;
mod compare_tracers;
mod doctor;
mod exports;
mod merge;
mod printed;
mod profile;
mod render;
mod report;
mod reproduce;
mod scale;
mod verify;

pub use accuracy::AccuracyArgs;
pub use baseline::{BaselineAction, BaselineArgs, FolderArgs, SaveArgs};
pub use check::{CheckArgs, ChildAction, ChildArgs, ThresholdArgs};
pub use compare::{CompareArgs, CompareFormat};
pub use compare_tracers::CompareTracersArgs;
pub use doctor::DoctorArgs;
pub use exports::ExportArgs;
pub use merge::MergeArgs;
pub use printed::{CompletionsArgs, ManArgs, SchemaArgs, SchemaOf};
pub use profile::ProfileArgs;
pub use render::{CostArgs, RenderArgs, STRUCTURE_SHADOWS, SamplingArgs};
pub use report::ReportArgs;
pub use reproduce::{HavranArgs, Publication, ReproduceArgs, ZachmannArgs};
pub use scale::{ScaleArgs, TrialArgs};
pub use verify::VerifyArgs;

use std::path::PathBuf;
use std::time::Duration;

use clap::builder::{OsStringValueParser, PossibleValue, PossibleValuesParser, TypedValueParser};
use clap::{Args, Parser, Subcommand, ValueEnum};
use scene_loading::source_names::name_of_path;

use measurement::rays::order::Orders;
use measurement::settings::choice::Choice;
use measurement::settings::{Lights, MeasuringSettings, Precision, RunSettings};
use studies::sweep::SweepSettings;

/// Benchmarks acceleration structures for ray tracing on standard scenes.
#[derive(Debug, Parser)]
#[command(name = "rtbench", version, about, propagate_version = true, max_term_width = 100)]
#[command(after_help = "Exit codes: 0 fine, 1 failure, 2 usage, 3 regression, 4 wrong hits, \
                        5 inconclusive (check --strict), 130 interrupted.")]
pub struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
    /// When to use colours; NO_COLOR is respected by `auto`.
    #[arg(long, global = true, value_enum, default_value_t = Color::Auto, value_name = "WHEN")]
    pub color: Color,
    /// No progress and no warnings on stderr.
    #[arg(short, long, global = true, conflicts_with = "verbose")]
    pub quiet: bool,
    /// Say on stderr what is done.
    #[arg(short, long, global = true)]
    pub verbose: bool,
    /// Sets of scenes and defaults of `run` [default: rtbench.toml here or in a folder above]
    #[arg(long, global = true, value_name = "FILE")]
    pub config: Option<PathBuf>,
}

/// When to use colours.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Color {
    /// On a terminal, unless NO_COLOR is set.
    Auto,
    /// Always.
    Always,
    /// Never.
    Never,
}

/// The subcommands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Measure structures on scenes and print the tables
    Run(RunArgs),
    /// Measure one parameter of a structure over its values
    Sweep(SweepArgs),
    /// Measure one scene in several sizes: how build, trace and memory grow
    Scale(ScaleArgs),
    /// Put the results of two or more runs side by side
    Compare(CompareArgs),
    /// List what there is
    List(ListArgs),
    /// Render a scene, with the effects it calls for, to a PNG or EXR image
    Render(RenderArgs),
    /// What an image costs by the lecture's product, factor by factor, predicted and measured
    Cost(CostArgs),
    /// One scene by samples, by cones and by beams: time against error
    CompareTracers(CompareTracersArgs),
    /// Inspect, check or fetch scenes
    Scenes(ScenesArgs),
    /// Check structures on the hard cases: awkward rays, primitives, cells
    Verify(VerifyArgs),
    /// What accuracy costs in time: variants of tests, walks, offsets, samples
    Accuracy(AccuracyArgs),
    /// Make a page to read of the results in a folder: tables, plots, break-even counts
    Report(ReportArgs),
    /// Put published figures beside ours
    Reproduce(ReproduceArgs),
    /// What the time of a run's fastest rows is spent on: work, and lines from caches and memory
    Profile(ProfileArgs),
    /// Hold this program against a baseline or against an older binary: the gate of a CI job
    Check(CheckArgs),
    /// Keep results to check against
    Baseline(BaselineArgs),
    /// What `check` and `scale` start as processes of their own
    #[command(hide = true)]
    Child(ChildArgs),
    /// Join the parts of a run that `--shard` made
    Merge(MergeArgs),
    /// Say what on this machine disturbs measurements, and what to do about it
    Doctor(DoctorArgs),
    /// Print the JSON schema of what is written
    Schema(SchemaArgs),
    /// Print completions for a shell
    Completions(CompletionsArgs),
    /// Print the manual page, or write the pages of all commands
    Man(ManArgs),
}

/// The name of a scene; of a file of any name, UTF-8 or not.
pub(crate) fn scene_name() -> impl TypedValueParser<Value = String> {
    OsStringValueParser::new().map(|name| name_of_path(&name))
}

/// One of the values of a setting.
pub(crate) fn choice<T: Choice + Send + Sync>() -> impl TypedValueParser<Value = T> {
    let values = T::ALL.iter().map(|(_, name, help)| PossibleValue::new(*name).help(*help));
    PossibleValuesParser::new(values).try_map(|text| T::typed(&text).ok_or("no such value"))
}

impl Command {
    /// Whether it goes on for long and has rows to lose.
    pub fn measures(&self) -> bool {
        matches!(
            self,
            Self::Run(_)
                | Self::Sweep(_)
                | Self::Scale(_)
                | Self::Cost(_)
                | Self::CompareTracers(_)
                | Self::Accuracy(_)
                | Self::Verify(_)
                | Self::Reproduce(_)
                | Self::Profile(_)
                | Self::Check(_)
                | Self::Baseline(_)
                | Self::Child(_)
        )
    }
}

/// `rtbench run`.
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
    /// How to measure.
    #[command(flatten)]
    pub measuring: MeasuringArgs,
    /// Measure one part of the table only: 2/8 is the second of eight; `rtbench merge` joins them
    #[arg(long, value_name = "I/N", value_parser = measurement::settings::shard::Shard::parse)]
    pub shard: Option<measurement::settings::shard::Shard>,
    /// Also print ratios of each kind of ray, and the time to a picture of a million primary rays
    #[arg(long)]
    pub by_kind: bool,
    /// Take what is not said from that set, as a run of it alone does: its rays, sizes, rows
    #[arg(long = "as", value_name = "SET")]
    pub as_set: Option<String>,
    /// What to write.
    #[command(flatten)]
    pub exports: ExportArgs,
    /// Finish the run that was begun with -o DIR: scenes that are finished are not measured again
    #[arg(long, value_name = "DIR", conflicts_with_all = ["scenes", "structures", "overrides",
          "rays", "rounds", "time_budget", "quick", "threads", "seed", "reference", "precision",
          "size", "shard", "order", "lights", "by_kind", "pass_limit", "as_set", "exports"])]
    pub resume: Option<PathBuf>,
}

/// `rtbench sweep`.
#[derive(Debug, Clone, Args)]
pub struct SweepArgs {
    /// Scenes, scene sets or scene files
    #[arg(value_name = "SCENE|SET", required = true, value_parser = scene_name())]
    pub scenes: Vec<String>,
    /// The structure, with its other settings if any: uniform-grid:resolution=woo
    #[arg(short, long, value_name = "STRUCTURE")]
    pub structure: String,
    /// The parameter
    #[arg(short, long, value_name = "PARAM")]
    pub parameter: String,
    /// Its values: none,array,hash
    #[arg(long, value_name = "VALUE", value_delimiter = ',',
          conflicts_with_all = ["from", "to", "steps", "linear"])]
    pub values: Vec<String>,
    /// Its first value, a number
    #[arg(
        long,
        value_name = "NUMBER",
        required_unless_present = "values",
        allow_negative_numbers = true
    )]
    pub from: Option<f64>,
    /// Its last value
    #[arg(
        long,
        value_name = "NUMBER",
        required_unless_present = "values",
        allow_negative_numbers = true
    )]
    pub to: Option<f64>,
    /// Number of values
    #[arg(long, value_name = "N", default_value_t = 9,
          value_parser = clap::value_parser!(u16).range(2..=1000))]
    pub steps: u16,
    /// Equal steps between values [default: equal ratios]
    #[arg(long)]
    pub linear: bool,
    /// Sets another parameter of the structure: resolution=woo
    #[arg(long = "set", value_name = "PARAM=VALUE")]
    pub settings: Vec<String>,
    /// How to measure.
    #[command(flatten)]
    pub measuring: MeasuringArgs,
    /// Write one CSV row a scene and value; - is standard output, instead of the tables
    #[arg(long, value_name = "FILE")]
    pub export_csv: Option<PathBuf>,
    /// Write a plot, one panel a scene; or -
    #[arg(long, value_name = "FILE")]
    pub export_svg: Option<PathBuf>,
    /// Write the tables in Markdown; or -
    #[arg(long, value_name = "FILE")]
    pub export_markdown: Option<PathBuf>,
    /// Write everything, raw samples too, as JSON; or -
    #[arg(long, value_name = "FILE")]
    pub export_json: Option<PathBuf>,
}

/// What all commands that measure have in common.
#[derive(Debug, Clone, Args)]
pub struct MeasuringArgs {
    /// Kinds of rays [default: all]
    #[arg(long, value_name = "KIND", value_delimiter = ',')]
    pub rays: Vec<String>,
    /// The order in which rows are asked the rays
    #[arg(long, value_parser = choice::<Orders>(),
          default_value = Orders::default().name())]
    pub order: Orders,
    /// Which lights shadow rays run to
    #[arg(long, value_parser = choice::<Lights>(),
          default_value = Lights::default().name())]
    pub lights: Lights,
    /// Longest pass over the rays; a slower row is timed on a sample of them [default: 200ms, 30ms
    /// with --quick]
    #[arg(long, value_name = "TIME", value_parser = measurement::settings::duration::parse)]
    pub pass_limit: Option<Duration>,
    /// Rounds: each visits every row once
    #[arg(long, value_name = "N", conflicts_with = "time_budget",
          value_parser = measurement::settings::quantity::count(1..=10_000))]
    pub rounds: Option<u32>,
    /// Go on with rounds until this time has passed, all scenes together: 60s, 1.5m, 2h30m
    #[arg(long, value_name = "TIME", value_parser = measurement::settings::duration::parse)]
    pub time_budget: Option<Duration>,
    /// Small images and few rounds: a first look
    #[arg(long)]
    pub quick: bool,
    /// Threads that build and trace
    #[arg(short = 'j', long, value_name = "N", default_value_t = 1,
          value_parser = clap::value_parser!(u16).range(1..=MeasuringSettings::MOST_THREADS.into()))]
    pub threads: u16,
    /// Seed of schedules, samples and intervals
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
    /// The row that ratios are taken to [default: obvhs-cwbvh, or the first row there is]
    #[arg(long, value_name = "STRUCTURE")]
    pub reference: Option<String>,
    /// Arithmetic of primitives and rays
    #[arg(long, value_parser = choice::<Precision>(),
          default_value = Precision::default().name())]
    pub precision: Precision,
    /// Width and height of the image
    #[arg(long, value_name = "PIXELS", value_parser = clap::value_parser!(u32).range(1..=MeasuringSettings::LARGEST_SIZE.into()))]
    pub size: Option<u32>,
}

impl MeasuringArgs {
    /// What was typed.
    pub fn settings(&self) -> MeasuringSettings {
        MeasuringSettings {
            rays: self.rays.clone(),
            order: self.order,
            lights: self.lights,
            pass_limit: self.pass_limit,
            rounds: self.rounds,
            time_budget: self.time_budget,
            quick: self.quick,
            threads: self.threads,
            seed: self.seed,
            reference: self.reference.clone(),
            precision: self.precision,
            size: self.size,
        }
    }
}

impl RunArgs {
    /// What was typed, but for the files to write.
    pub fn settings(&self) -> RunSettings {
        RunSettings {
            scenes: self.scenes.clone(),
            structures: self.structures.clone(),
            overrides: self.overrides.clone(),
            measuring: self.measuring.settings(),
            shard: self.shard,
            by_kind: self.by_kind,
        }
    }
}

/// What `--set` says in the command line of a run, program first; nothing where it is none of a run.
pub fn overrides_in(command_line: &[String]) -> Vec<String> {
    match Cli::try_parse_from(command_line).map(|cli| cli.command) {
        Ok(Command::Run(args)) => args.overrides,
        Ok(Command::Baseline(args)) => match args.action {
            BaselineAction::Save(args) => args.run.overrides,
            _ => Vec::new(),
        },
        _ => Vec::new(),
    }
}

impl SweepArgs {
    /// What was typed, but for the files to write.
    pub fn settings(&self) -> SweepSettings {
        SweepSettings {
            scenes: self.scenes.clone(),
            structure: self.structure.clone(),
            parameter: self.parameter.clone(),
            values: self.values.clone(),
            from: self.from,
            to: self.to,
            steps: self.steps,
            linear: self.linear,
            settings: self.settings.clone(),
            measuring: self.measuring.settings(),
        }
    }
}

/// `rtbench list`.
#[derive(Debug, Clone, Args)]
pub struct ListArgs {
    /// What to list
    #[arg(value_enum)]
    pub what: Listed,
    /// As text or as JSON
    #[arg(long, value_enum, default_value_t = Format::Text)]
    pub format: Format,
}

/// What can be listed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Listed {
    /// Structures with their parameters
    Structures,
    /// Occluders, which answer shadow rays, with their parameters
    Occluders,
    /// Tracers, which make images, with what each assumes and refuses
    Tracers,
    /// Scenes by name
    Scenes,
    /// Sets of scenes
    Sets,
    /// Kinds of rays
    Rays,
    /// Axes of accuracy
    Axes,
}

/// How to print a list.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Format {
    /// For reading
    Text,
    /// For programs
    Json,
}

/// `rtbench scenes`.
#[derive(Debug, Clone, Args)]
pub struct ScenesArgs {
    /// What to do with them.
    #[command(subcommand)]
    pub action: ScenesAction,
}

/// What to do with scenes.
#[derive(Debug, Clone, Subcommand)]
pub enum ScenesAction {
    /// Say what scenes consist of
    Info(SceneNames),
    /// Load scenes and report everything that is wrong with them
    Validate(SceneNames),
    /// Bring scenes that come inside packages to this machine
    Fetch(SceneNames),
}

/// Names of scenes.
#[derive(Debug, Clone, Args)]
pub struct SceneNames {
    /// Scenes, sets or files [default: all scenes]
    #[arg(value_name = "NAME", value_parser = scene_name())]
    pub names: Vec<String>,
}
