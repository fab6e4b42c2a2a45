//! What all commands that measure have in common.

use std::time::Duration;

use crate::args::parsers::choice;
use clap::Args;
use measurement::rays::order::Orders;
use measurement::settings::{Lights, MeasuringSettings, Precision, quantity};

/// What all commands that measure have in common.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Measuring")]
pub struct MeasuringArgs {
    /// Kinds of rays [default: all]
    #[arg(long, value_name = "KIND", value_delimiter = ',')]
    pub rays: Vec<String>,
    /// Rounds: each visits every row once [default: 5, 3 with --quick]
    #[arg(long, value_name = "N", conflicts_with = "time_budget",
          value_parser = measurement::settings::quantity::count(1..=MeasuringSettings::MOST_ROUNDS))]
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
    /// The reference row of ratios [default: obvhs-cwbvh, else obvhs-cwbvh adapter=robust, else
    /// the first row there is]
    #[arg(long, value_name = "STRUCTURE")]
    pub reference: Option<String>,
    /// Arithmetic of primitives and rays
    #[arg(long, value_parser = choice::<Precision>(),
          default_value = Precision::default().name())]
    pub precision: Precision,
    /// Width and height of the image [default: 128, 48 with --quick; sets may say otherwise]
    #[arg(long, value_name = "PIXELS", value_parser = clap::value_parser!(u32).range(1..=MeasuringSettings::LARGEST_SIZE.into()))]
    pub size: Option<u32>,
}

impl MeasuringArgs {
    pub fn settings(&self) -> MeasuringSettings {
        MeasuringSettings {
            rays: self.rays.clone(),
            rounds: self.rounds,
            time_budget: self.time_budget,
            quick: self.quick,
            threads: self.threads,
            seed: self.seed,
            reference: self.reference.clone(),
            precision: self.precision,
            size: self.size,
            ..MeasuringSettings::default()
        }
    }
}

/// How rays are issued to rows.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Measuring")]
pub struct IssueArgs {
    /// The order in which rays are issued to rows
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
}

impl IssueArgs {
    /// These settings, where the others are those.
    pub fn over(&self, others: MeasuringSettings) -> MeasuringSettings {
        let Self { order, lights, pass_limit } = *self;
        MeasuringSettings { order, lights, pass_limit, ..others }
    }
}

/// How much memory a structure may take.
#[derive(Debug, Clone, Args)]
pub struct MemoryArgs {
    /// Most memory of a structure; a row that would take more is shown as `out of memory` [default:
    /// half of the machine's memory, or of the control group's limit if that is less]
    #[arg(long, value_name = "BYTES", value_parser = quantity::bytes)]
    pub max_memory: Option<u64>,
}
