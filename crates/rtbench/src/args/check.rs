//! `rtbench check`, and what commands start as processes of their own.

use std::path::PathBuf;
use std::time::Duration;

use crate::args::measuring::{PluginArgs, ServeArgs};
use crate::args::parsers::{choice, percent, scene_name, threads};
use crate::args::results::FolderArgs;
use crate::gate::thresholds::Thresholds;
use clap::{Args, Subcommand};
use measurement::plan::error::PlanError;
use measurement::settings::quantity::duration;
use measurement::settings::{MeasuringSettings, Precision, RunSettings};

#[derive(Debug, Clone, Args)]
pub struct CheckArgs {
    /// Scenes to check, of those in the baseline; without a baseline, any [default: all of the
    /// baseline]
    #[arg(value_name = "SCENE", value_parser = scene_name())]
    pub scenes: Vec<String>,
    /// Baseline to compare with: its name, a results.json, or the folder of `run -o`
    #[arg(short, long, value_name = "FILE|NAME", required_unless_present = "against")]
    pub baseline: Option<String>,
    /// Compare with this older rtbench binary, measured in turns with this one; with --plugin, with
    /// this older build of the plugin
    #[arg(long, value_name = "FILE")]
    pub against: Vec<PathBuf>,
    /// Check these results of an earlier run, and measure nothing
    #[arg(long, value_name = "DIR|FILE", requires = "baseline", conflicts_with_all = ["against",
          "plugin", "rounds", "time_budget", "instructions"])]
    pub results: Option<PathBuf>,
    /// Compare row OLD of the baseline or older program with row NEW of this one; the name of a
    /// structure stands for all its rows
    #[arg(long = "match", value_name = "OLD=NEW")]
    pub matches: Vec<String>,
    /// Allow this row, or structure, to be missing on one side despite --strict
    #[arg(long, value_name = "ROW")]
    pub allow_missing: Vec<String>,
    /// Judge times even if the baseline is of another processor
    #[arg(long)]
    pub across_processors: bool,
    /// Use this set's thresholds of rows and kinds of rays [default: those of the set that is the
    /// only SCENE]
    #[arg(long = "as", value_name = "SET")]
    pub as_set: Option<String>,
    /// Rows, of those in the baseline: a structure, or a label [default: all]
    #[arg(short, long, alias = "structure", value_name = "STRUCTURE", value_delimiter = ',')]
    pub structures: Vec<String>,
    /// Rounds; without a baseline, turns of a process of each [default: 15, or those of the
    /// baseline if more]
    #[arg(long, value_name = "N", conflicts_with = "time_budget",
          value_parser = clap::value_parser!(u32).range(1..=10_000))]
    pub rounds: Option<u32>,
    /// Keep measuring until this time has elapsed: 60s, 2m
    #[arg(long, value_name = "TIME", value_parser = duration)]
    pub time_budget: Option<Duration>,
    /// Count instructions under valgrind, or not [default: if the baseline has counts]
    #[arg(long, value_name = "BOOL", num_args = 0..=1, require_equals = true,
          default_missing_value = "true", conflicts_with = "plugin")]
    pub instructions: Option<bool>,
    /// Exit with code 5 if a comparison is inconclusive, or a row is missing on one side
    #[arg(long)]
    pub strict: bool,
    /// Also print rows that did not change
    #[arg(long)]
    pub all: bool,
    #[command(flatten)]
    pub thresholds: ThresholdArgs,
    #[command(flatten)]
    pub folder: FolderArgs,
    /// Kinds of rays, as for `run`
    #[arg(long, value_name = "KIND", value_delimiter = ',', conflicts_with = "baseline")]
    pub rays: Vec<String>,
    /// Use small images, as for `run`
    #[arg(long, conflicts_with = "baseline")]
    pub quick: bool,
    /// Threads that build and trace [default: 1]
    #[arg(short = 'j', long, value_name = "N", conflicts_with = "baseline",
          value_parser = threads())]
    pub threads: Option<u16>,
    /// Floating-point precision of primitives and rays [default: f32]
    #[arg(long, value_parser = choice::<Precision>(), conflicts_with = "baseline")]
    pub precision: Option<Precision>,
    /// Width and height of the image, as for `run`
    #[arg(long, value_name = "PIXELS", conflicts_with = "baseline",
          value_parser = clap::value_parser!(u32).range(1..=8192))]
    pub size: Option<u32>,
    /// Write check.json, check.csv and check.md to DIR, and the results as `run -o` does
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// Structures of yours that the baseline has.
    #[command(flatten)]
    pub plugins: PluginArgs,
}

/// Thresholds of regressions for `check`.
#[derive(Debug, Clone, Copy, Default, Args)]
pub struct ThresholdArgs {
    /// Report a regression if instructions grow by more than this [default: 0.5%]
    #[arg(long, value_name = "PERCENT", value_parser = percent)]
    pub instruction_threshold: Option<f64>,
    /// Report a regression if a time grows significantly by more than this, unless the set has a
    /// threshold for it [default: 5%; 2% if programs or plugins are measured in turns]
    #[arg(short = 't', long, value_name = "PERCENT", value_parser = percent)]
    pub time_threshold: Option<f64>,
    /// Probability of at least one false alarm among all times of a check [default: 0.05]
    #[arg(long, value_name = "P")]
    pub significance: Option<f64>,
    /// Ignore times shorter than this [default: 200us]
    #[arg(long, value_name = "TIME", value_parser = duration)]
    pub shortest: Option<Duration>,
}

impl ThresholdArgs {
    /// The options, and defaults of those that are not given.
    pub fn over(&self, default: Thresholds) -> Result<Thresholds, PlanError> {
        let significance = self.significance.unwrap_or(default.significance);
        if !(significance > 0.0 && significance < 1.0) {
            return Err(PlanError::Invalid(format!(
                "significance: {significance} is out of range; expected between 0 and 1"
            )));
        }
        Ok(Thresholds {
            instructions: self.instruction_threshold.unwrap_or(default.instructions),
            time: self.time_threshold.unwrap_or(default.time),
            significance,
            shortest: self.shortest.map_or(default.shortest, |t| t.as_secs_f64()),
            ..default
        })
    }
}

impl CheckArgs {
    /// Two programs, or two builds of a plugin, are measured in turns.
    pub fn takes_turns(&self) -> bool {
        !self.against.is_empty()
    }

    /// The older rtbench binary; none with `--plugin`, whose older builds are compared.
    pub fn older_binary(&self) -> Option<&PathBuf> {
        self.against.first().filter(|_| self.plugins.plugin.is_empty())
    }

    /// Description of the older side.
    pub fn against_in_words(&self) -> String {
        if let Some(old) = self.older_binary() {
            return format!("binary {}", old.display());
        }
        match &self.against[..] {
            [] => format!("baseline {}", self.baseline.as_deref().unwrap_or_default()),
            files => {
                let files: Vec<_> = files.iter().map(|f| f.display().to_string()).collect();
                format!("plugin {}", files.join(", "))
            }
        }
    }

    /// Settings of a comparison without a baseline.
    pub fn settings(&self) -> RunSettings {
        let default = MeasuringSettings::default();
        RunSettings {
            scenes: self.scenes.clone(),
            structures: self.structures.clone(),
            measuring: MeasuringSettings {
                rays: self.rays.clone(),
                quick: self.quick,
                threads: self.threads.unwrap_or(default.threads),
                precision: self.precision.unwrap_or_default(),
                size: self.size,
                ..default
            },
            ..RunSettings::default()
        }
    }
}

/// Arguments of child processes that `check` and `sweep` start.
#[derive(Debug, Clone, Args)]
pub struct ChildArgs {
    /// Task of the child; its record comes on standard input, except for `build`.
    #[command(subcommand)]
    pub action: ChildAction,
    /// Structures of the parent's plugins.
    #[command(flatten)]
    pub plugins: PluginArgs,
}

/// Task of a child with the record on its standard input; it answers in JSON.
#[derive(Debug, Clone, Subcommand)]
pub enum ChildAction {
    /// Measure the record's rows anew
    Measure {
        #[arg(long, default_value_t = 1)]
        rounds: u32,
        /// Check only a few answers: an earlier child checked them all
        #[arg(long)]
        lightly: bool,
        /// Its number among the processes of a run.
        #[arg(long, default_value_t = 0)]
        process: u32,
        /// Its first round: those of all processes are counted through.
        #[arg(long, default_value_t = 0)]
        first_round: u32,
    },
    /// Build and trace the row named by each line of standard input; the first line is the record
    Laps,
    /// Time the variants of axes of accuracy: `AccuracyArgs` on standard input
    Accuracy,
    /// Build and trace each row once, for an instruction counter
    CountInstructions,
    /// Build one row and print the memory that it takes; ends when standard input ends
    Build(TrialArgs),
    /// Answer rays with a plugin over a socket; ends when standard input ends
    Plugin(ServeArgs),
}

#[derive(Debug, Clone, Args)]
pub struct TrialArgs {
    /// Scene whose structure is built
    #[arg(long, value_parser = scene_name())]
    pub scene: String,
    /// Structure with its settings
    #[arg(long)]
    pub row: String,
    /// Number of threads that build
    #[arg(long, default_value_t = 1, value_parser = threads())]
    pub threads: u16,
    /// Precision of primitives and rays
    #[arg(long, value_parser = choice::<Precision>(), default_value = Precision::default().name())]
    pub precision: Precision,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_override_defaults_and_nonsense_is_refused() {
        let args = ThresholdArgs { instruction_threshold: Some(0.02), ..ThresholdArgs::default() };
        let thresholds = args.over(Thresholds::default()).unwrap();
        assert_eq!((thresholds.instructions, thresholds.time), (0.02, 0.05));
        for significance in [0.0, 1.0, f64::NAN] {
            let args = ThresholdArgs { significance: Some(significance), ..args };
            let error = args.over(Thresholds::default()).unwrap_err().to_string();
            assert!(error.contains("between 0 and 1"), "{error}");
        }
    }
}
