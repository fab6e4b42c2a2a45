//! `rtbench check`, and what commands start as processes of their own.

use std::path::PathBuf;
use std::time::Duration;

use crate::args::baseline::FolderArgs;
use crate::args::parsers::{choice, percent, scene_name};
use crate::args::plugins::{PluginArgs, ServeArgs};
use crate::gate::thresholds::Thresholds;
use clap::{Args, Subcommand};
use measurement::settings::{MeasuringSettings, Precision, RunSettings};

/// `rtbench check`.
#[derive(Debug, Clone, Args)]
pub struct CheckArgs {
    /// Scenes, of those that the baseline has; without a baseline, any [default: all of the
    /// baseline]
    #[arg(value_name = "SCENE", value_parser = scene_name())]
    pub scenes: Vec<String>,
    /// What to check against: the name of a baseline, a results.json, or the folder of `run -o`
    #[arg(short, long, value_name = "FILE|NAME",
          required_unless_present_any = ["against", "against_plugin"])]
    pub baseline: Option<String>,
    /// An older rtbench binary, measured in turns with this one
    #[arg(long, value_name = "BINARY", conflicts_with = "plugin")]
    pub against: Option<PathBuf>,
    /// The older build of the plugin that --plugin names, measured in turns with it
    #[arg(long, value_name = "FILE", requires = "plugin", conflicts_with = "against")]
    pub against_plugin: Vec<PathBuf>,
    /// Check these results of an earlier run, and measure nothing
    #[arg(long, value_name = "DIR|FILE", requires = "baseline", conflicts_with_all = ["against",
          "against_plugin", "plugin", "rounds", "time_budget", "instructions", "output"])]
    pub results: Option<PathBuf>,
    /// Compare a row that has another name now: OLD in the baseline or the older program with NEW
    /// of this one; of a structure, all its rows
    #[arg(long = "match", value_name = "OLD=NEW")]
    pub matches: Vec<String>,
    /// A row, or a structure, that one side may lack though --strict is given
    #[arg(long, value_name = "ROW")]
    pub allow_missing: Vec<String>,
    /// Judge times though the baseline is of another processor
    #[arg(long)]
    pub across_processors: bool,
    /// Take thresholds of rows and kinds of rays from the file of that set [default: of the set that is the
    /// only SCENE]
    #[arg(long = "as", value_name = "SET")]
    pub as_set: Option<String>,
    /// Rows, of those that the baseline has: a structure, or a label [default: all]
    #[arg(short, long, value_name = "STRUCTURE", value_delimiter = ',')]
    pub structures: Vec<String>,
    /// Rounds; without a baseline, turns of a process of each [default: 15, or those of the baseline if more]
    #[arg(long, value_name = "N", conflicts_with = "time_budget",
          value_parser = clap::value_parser!(u32).range(1..=10_000))]
    pub rounds: Option<u32>,
    /// Go on with rounds until this time has passed: 60s, 2m
    #[arg(long, value_name = "TIME", value_parser = measurement::settings::duration::parse)]
    pub time_budget: Option<Duration>,
    /// Count instructions under valgrind [default: where the baseline has counts]
    #[arg(long, overrides_with = "no_instructions", conflicts_with = "plugin")]
    pub instructions: bool,
    /// Count none
    #[arg(long)]
    pub no_instructions: bool,
    /// Exit with 5 where something is inconclusive, or a row is missing on one side
    #[arg(long)]
    pub strict: bool,
    /// Print what did not change, too
    #[arg(long)]
    pub all: bool,
    /// What counts as a regression.
    #[command(flatten)]
    pub thresholds: ThresholdArgs,
    /// Where baselines are kept.
    #[command(flatten)]
    pub folder: FolderArgs,
    /// How to measure without a baseline.
    #[command(flatten)]
    pub measuring: AgainstArgs,
    /// Structures of yours that the baseline has.
    #[command(flatten)]
    pub plugins: PluginArgs,
    /// Keep what was measured there, as `run -o` does
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// Write one CSV row for each thing judged
    #[arg(long, value_name = "FILE")]
    pub export_csv: Option<PathBuf>,
    /// Write the tables in Markdown
    #[arg(long, value_name = "FILE")]
    pub export_markdown: Option<PathBuf>,
    /// Write everything as JSON
    #[arg(long, value_name = "FILE")]
    pub export_json: Option<PathBuf>,
}

/// What `check` takes for a regression.
#[derive(Debug, Clone, Copy, Default, Args)]
pub struct ThresholdArgs {
    /// More instructions than that are a regression [default: 0.5%]
    #[arg(long, value_name = "PERCENT", value_parser = percent)]
    pub instruction_threshold: Option<f64>,
    /// A time longer by more than that is one, where that is certain and the set has no threshold for it
    /// [default: 5%; 2% where programs or plugins are measured in turns]
    #[arg(short = 't', long, value_name = "PERCENT", value_parser = percent)]
    pub time_threshold: Option<f64>,
    /// Probability of one false alarm in all times of a check [default: 0.05]
    #[arg(long, value_name = "P")]
    pub significance: Option<f64>,
    /// Ratios within a run are not trusted where some thread waited for a processor for a longer
    /// part of it [default: 20%]
    #[arg(long, value_name = "PERCENT", value_parser = percent)]
    pub busiest: Option<f64>,
    /// Times shorter than that are not judged [default: 200us]
    #[arg(long, value_name = "TIME", value_parser = measurement::settings::duration::parse)]
    pub shortest: Option<Duration>,
}

impl ThresholdArgs {
    /// What was typed, over what is configured.
    pub fn over(&self, configured: Thresholds) -> Thresholds {
        Thresholds {
            instructions: self.instruction_threshold.unwrap_or(configured.instructions),
            time: self.time_threshold.unwrap_or(configured.time),
            busiest: self.busiest.unwrap_or(configured.busiest),
            significance: self.significance.unwrap_or(configured.significance),
            shortest: self.shortest.map_or(configured.shortest, |t| t.as_secs_f64()),
            rows: configured.rows,
        }
    }
}

/// What the baseline says where there is one.
#[derive(Debug, Clone, Args)]
pub struct AgainstArgs {
    /// Kinds of rays, as for `run`
    #[arg(long, value_name = "KIND", value_delimiter = ',', conflicts_with = "baseline")]
    pub rays: Vec<String>,
    /// Small images, as for `run`
    #[arg(long, conflicts_with = "baseline")]
    pub quick: bool,
    /// Threads that build and trace [default: 1]
    #[arg(short = 'j', long, value_name = "N", conflicts_with = "baseline",
          value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// Arithmetic of primitives and rays [default: f32]
    #[arg(long, value_parser = choice::<Precision>(), conflicts_with = "baseline")]
    pub precision: Option<Precision>,
    /// Width and height of the image, as for `run`
    #[arg(long, value_name = "PIXELS", conflicts_with = "baseline",
          value_parser = clap::value_parser!(u32).range(1..=8192))]
    pub size: Option<u32>,
}

impl CheckArgs {
    /// Two programs, or two builds of a plugin, are measured in turns.
    pub fn takes_turns(&self) -> bool {
        self.against.is_some() || !self.against_plugin.is_empty()
    }

    /// What is compared without a baseline.
    pub fn settings(&self) -> RunSettings {
        let how = &self.measuring;
        let default = MeasuringSettings::default();
        RunSettings {
            scenes: self.scenes.clone(),
            structures: self.structures.clone(),
            measuring: MeasuringSettings {
                rays: how.rays.clone(),
                quick: how.quick,
                threads: how.threads.unwrap_or(default.threads),
                precision: how.precision.unwrap_or_default(),
                size: how.size,
                ..default
            },
            ..RunSettings::default()
        }
    }
}

/// What `check` and `sweep` start.
#[derive(Debug, Clone, Args)]
pub struct ChildArgs {
    /// Structures of the parent's plugins.
    #[command(flatten)]
    pub plugins: PluginArgs,
    /// What to do; the record that says of what comes on standard input, but for `build`.
    #[command(subcommand)]
    pub action: ChildAction,
}

/// What a child does with the record on its standard input; it answers in JSON.
#[derive(Debug, Clone, Subcommand)]
pub enum ChildAction {
    /// Measure the record's rows anew
    Measure {
        /// Rounds.
        #[arg(long, default_value_t = 1)]
        rounds: u32,
        /// Check few answers: an earlier child checked them all
        #[arg(long)]
        lightly: bool,
        /// Its number among the processes of a run.
        #[arg(long, default_value_t = 0)]
        process: u32,
        /// Its first round: those of all processes are counted through.
        #[arg(long, default_value_t = 0)]
        first_round: u32,
    },
    /// Build and ask a row for each line on standard input that names one, behind the record, which is a line, too
    Laps,
    /// Time the variants of axes of accuracy: `AccuracyArgs` on standard input
    Accuracy,
    /// Build and ask each row once, for a counter of instructions
    CountInstructions,
    /// Build one row and say how much memory that took; ends when standard input ends
    Build(TrialArgs),
    /// Answer rays with a plugin, as a run asks over a socket; ends when standard input ends
    Plugin(ServeArgs),
}

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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_typed_comes_before_what_is_configured() {
        let args = ThresholdArgs { instruction_threshold: Some(0.02), ..ThresholdArgs::default() };
        let thresholds = args.over(Thresholds::default());
        assert_eq!((thresholds.instructions, thresholds.time), (0.02, 0.05));
    }
}
