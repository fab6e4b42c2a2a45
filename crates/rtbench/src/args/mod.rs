//! The command line as typed: syntax only. What it means is decided in [`measurement::plan`].

use clap::{Args, Parser, Subcommand, ValueEnum};
use scene_loading::ViewOptions;
use scene_loading::view_options::{CameraOption, LightOption, UpOption};

mod check;
mod files;
mod list;
mod measuring;
mod parsers;
mod render;
mod results;
mod run;
pub mod show;
mod studies;

pub use check::{CheckArgs, ChildAction, ChildArgs, ThresholdArgs, TrialArgs};
pub use files::{CheckRaysArgs, ExportRaysArgs, RayFormat, RaysAction, TraceArgs};
pub use list::{
    DoctorArgs, Format, GeneratedText, ListArgs, ListSubject, ManArgs, SceneNames, ScenesAction,
    SchemaOf,
};
pub use measuring::{ExportArgs, MeasuringArgs, PluginArgs, ServeArgs, TableArgs};
pub(crate) use parsers::percent;
pub use render::{CostArgs, RenderArgs, STRUCTURE_SHADOWS, SamplingArgs};
pub use results::{
    BaselineAction, BaselineArgs, CompareArgs, CompareFormat, FolderArgs, HistoryArgs, MergeArgs,
    ReportArgs, SaveArgs,
};
pub use run::{RunArgs, SweepArgs};
pub use show::ShowArgs;
pub use studies::{
    AccuracyArgs, AnimateArgs, CompareTracersArgs, ExplainArgs, HavranArgs, Publication,
    VerifyArgs, ZachmannArgs,
};

/// The head of options that every command has.
const GLOBAL: &str = "Every command";

/// Benchmarks acceleration structures for ray tracing on standard scenes.
#[derive(Debug, Parser)]
#[command(name = "rtbench", version, long_version = env!("RTBENCH_VERSION"), about)]
#[command(propagate_version = true, max_term_width = 100)]
#[command(after_help = "Exit codes: 0 fine, 1 failure, 2 usage, 3 regression, 4 wrong hits, \
                        5 inconclusive (check --strict), 130 interrupted.")]
pub struct Cli {
    #[command(subcommand)]
    pub command: Command,
    /// When to use colours; NO_COLOR is respected by `auto`.
    #[arg(long, global = true, help_heading = GLOBAL, value_enum, default_value_t = Color::Auto, value_name = "WHEN")]
    pub color: Color,
    /// Print no progress and no warnings to stderr.
    #[arg(short, long, global = true, help_heading = GLOBAL, conflicts_with = "verbose")]
    pub quiet: bool,
    /// Print verbose progress to stderr.
    #[arg(short, long, global = true, help_heading = GLOBAL)]
    pub verbose: bool,
    /// Allow scene files to read files outside their folders (only for scenes that you trust)
    #[arg(long, global = true, help_heading = GLOBAL)]
    pub allow_outside: bool,
    #[command(flatten)]
    pub view: ViewArgs,
    /// Overwrite existing output
    #[arg(long, global = true, help_heading = GLOBAL)]
    pub overwrite: bool,
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

#[derive(Debug, Subcommand)]
pub enum Command {
    /// Measure structures on scenes and print the tables
    #[command(
        after_help = "Examples:\n  rtbench run my.obj                                  which structure for this file\n  rtbench run teapot -s kd-tree,wide-bvh -o out       two structures, results in a folder\n  rtbench run teapot --quick --sort memory            a first look, the smallest first\n  rtbench run tree -s uniform-grid:density=4          a structure with a setting"
    )]
    Run(RunArgs),
    /// Measure one parameter of a structure over its values, or one scene in several sizes
    #[command(
        after_help = "Examples:\n  rtbench sweep teapot -s uniform-grid -p density --values 0.1..100\n  rtbench sweep tree-tess --sizes 1e3..1e6 -s kd-tree,wide-bvh"
    )]
    Sweep(SweepArgs),
    /// Measure a moving scene frame by frame: updates, rays, frames per second
    #[command(
        after_help = "Examples:\n  rtbench animate marbles                                every structure, every way to update it\n  rtbench animate city -s wide-bvh:update=refit,uniform-grid:update=incremental -o out\n  rtbench animate 'frame%04d.obj' --frames 0..9 -j 2     a sequence of files, with one thread and with two"
    )]
    Animate(AnimateArgs),
    /// Explain why two rows differ in time: structure, kernel, query
    #[command(after_help = "Examples:\n  rtbench explain gears-tess -s kd-tree")]
    Explain(ExplainArgs),
    /// Compare the results of two or more runs
    #[command(
        after_help = "Examples:\n  rtbench compare before after -t 5%\n  rtbench compare before after --match hug=hug:density=4"
    )]
    Compare(CompareArgs),
    /// List structures, scenes, sets, rays and axes
    #[command(after_help = "Examples:\n  rtbench list structures kd-tree")]
    List(ListArgs),
    /// Render a scene, with its effects, to a PNG or EXR image
    #[command(after_help = "Examples:\n  rtbench render teapot -o teapot.png --size 256")]
    Render(RenderArgs),
    /// Draw structures: cells in a slice or as boxes, levels, the path of one ray
    #[command(
        after_help = "Examples:\n  rtbench show teapot -s uniform-grid,octree,kd-tree,wide-bvh -o slice.svg"
    )]
    Show(ShowArgs),
    /// Predict and measure the cost of an image by Zachmann's product, factor by factor
    #[command(after_help = "Examples:\n  rtbench cost teapot --heat-maps maps")]
    Cost(CostArgs),
    /// Compare sampling, cone and beam tracing of a scene: time against error
    CompareTracers(CompareTracersArgs),
    /// Inspect, check or fetch scenes
    #[command(subcommand)]
    Scenes(ScenesAction),
    /// Write rays for another program, check its answers, or trace rays from a file
    #[command(subcommand)]
    Rays(RaysAction),
    /// Check structures on the hard cases: awkward rays, primitives, cells
    #[command(after_help = "Examples:\n  rtbench verify -s kd-tree --rays 1000")]
    Verify(VerifyArgs),
    /// Measure what accuracy costs in time: variants of tests, traversals, offsets, samples
    Accuracy(AccuracyArgs),
    /// Make an HTML report of the results in a folder: tables, plots, break-even counts
    #[command(
        after_help = "Examples:\n  rtbench report out\n  rtbench report before after -o both.html    two runs side by side"
    )]
    Report(ReportArgs),
    /// Make a static site of many runs: ratios over commits, and the commits that changed them
    #[command(after_help = "Examples:\n  rtbench history nights -o site")]
    History(HistoryArgs),
    /// Compare our figures with published figures
    #[command(subcommand)]
    Reproduce(Publication),
    /// Compare with a baseline, an older rtbench or an older plugin: the gate of a CI job
    #[command(
        after_help = "Examples:\n  rtbench check --baseline main\n  rtbench check teapot --against ./old\n  rtbench check teapot -s mine --plugin new/mine.so --against old/mine.so"
    )]
    Check(CheckArgs),
    /// Manage baselines for `check`
    Baseline(BaselineArgs),
    /// Child processes of `check` and `sweep`
    #[command(hide = true)]
    Child(ChildArgs),
    /// Merge the shards of a run made with `--shard`
    #[command(after_help = "Examples:\n  rtbench merge part-1 part-2 -o whole")]
    Merge(MergeArgs),
    /// Report what may disturb measurements on this machine, and how to fix it
    Doctor(DoctorArgs),
    /// Generate the manual page, completions for a shell, or JSON schemas
    #[command(subcommand)]
    Generate(GeneratedText),
}

impl Command {
    /// The plugins that it names.
    pub fn plugins(&self) -> Option<&PluginArgs> {
        Some(match self {
            Self::Run(args) => &args.plugins,
            Self::Verify(args) => &args.plugins,
            Self::Rays(RaysAction::Trace(args)) => &args.plugins,
            Self::Check(args) => &args.plugins,
            Self::Child(args) => &args.plugins,
            Self::Baseline(BaselineArgs { action: BaselineAction::Save(args), .. }) => {
                &args.run.plugins
            }
            _ => return None,
        })
    }

    /// Whether it goes on for long and has rows to lose.
    pub fn measures(&self) -> bool {
        matches!(
            self,
            Self::Run(_)
                | Self::Sweep(_)
                | Self::Animate(_)
                | Self::Explain(_)
                | Self::Cost(_)
                | Self::CompareTracers(_)
                | Self::Accuracy(_)
                | Self::Verify(_)
                | Self::Reproduce(_)
                | Self::Check(_)
                | Self::Baseline(_)
                | Self::Child(_)
        )
    }
}

/// The options of a run in a recorded command line, program first; none of other commands, and of
/// what this program does not read.
fn run_in(command_line: &[String]) -> Option<RunArgs> {
    match Cli::try_parse_from(command_line).ok()?.command {
        Command::Run(args) => Some(args),
        Command::Baseline(BaselineArgs { action: BaselineAction::Save(args), .. }) => {
            Some(args.run)
        }
        _ => None,
    }
}

/// Whether the command line of a run names structures, as far as is known.
pub fn names_structures(command_line: &[String]) -> bool {
    run_in(command_line).is_none_or(|args| !args.structures.is_empty())
}

/// Values of `--set` in the command line of a run.
pub fn overrides_in(command_line: &[String]) -> Vec<String> {
    run_in(command_line).map(|args| args.overrides).unwrap_or_default()
}

/// The view and the lights that scenes are given from the command line, of every command that loads
/// scenes.
#[derive(Debug, Clone, Default, Args)]
#[command(next_help_heading = "View and lights")]
pub struct ViewArgs {
    /// Camera, in world units and degrees: 1,2,3:0,0,0:45 [default: the scene's, or one that frames
    /// it]
    #[arg(long, global = true, value_name = "FROM:AT[:FOV]", allow_hyphen_values = true)]
    pub camera: Option<CameraOption>,
    /// Up direction of the camera [default: the scene's, or 0,1,0]
    #[arg(long, global = true, value_name = "X,Y,Z", allow_hyphen_values = true)]
    pub up: Option<UpOption>,
    /// Point light, repeatable: 0,10,0 or 0,10,0:1,0.9,0.8 [default: the scene's, or one at the
    /// eye]
    #[arg(long, global = true, value_name = "POS[:COLOR]", allow_hyphen_values = true)]
    pub light: Vec<LightOption>,
}

impl ViewArgs {
    pub fn options(&self) -> ViewOptions {
        ViewOptions { camera: self.camera, up: self.up, lights: self.light.clone() }
    }
}
