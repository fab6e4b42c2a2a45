//! Options shared by all commands that measure.

use std::time::Duration;

use crate::args::parsers::choice;
use clap::Args;
use measurement::rays::order::Orders;
use measurement::settings::{Lights, MeasuringSettings, Precision, quantity};

/// Options shared by all commands that measure.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Measuring")]
pub struct MeasuringArgs {
    /// Kinds of rays to trace [default: all]
    #[arg(long, value_name = "KIND", value_delimiter = ',')]
    pub rays: Vec<String>,
    /// Rounds; each measures every row once [default: 5, 3 with --quick]
    #[arg(long, value_name = "N", conflicts_with = "time_budget",
          value_parser = measurement::settings::quantity::count(1..=MeasuringSettings::MOST_ROUNDS))]
    pub rounds: Option<u32>,
    /// Keep measuring until this time has elapsed, all scenes together: 60s, 1.5m, 2h30m
    #[arg(long, value_name = "TIME", value_parser = measurement::settings::duration::parse)]
    pub time_budget: Option<Duration>,
    /// Use small images and few rounds, for a first look
    #[arg(long)]
    pub quick: bool,
    /// Number of threads that build and trace
    #[arg(short = 'j', long, value_name = "N", default_value_t = 1,
          value_parser = clap::value_parser!(u16).range(1..=MeasuringSettings::MOST_THREADS.into()))]
    pub threads: u16,
    /// Seed of schedules, samples and intervals
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
    /// Reference row of ratios [default: obvhs-cwbvh, else obvhs-cwbvh adapter=robust, else the
    /// first row]
    #[arg(long, value_name = "STRUCTURE")]
    pub reference: Option<String>,
    /// Floating-point precision of primitives and rays
    #[arg(long, value_parser = choice::<Precision>(),
          default_value = Precision::default().name())]
    pub precision: Precision,
    /// Width and height of the image [default: 128, 48 with --quick, unless the set has its own]
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

/// Order and limits of the rays.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Measuring")]
pub struct IssueArgs {
    /// Order in which rays are issued to rows
    #[arg(long, value_parser = choice::<Orders>(),
          default_value = Orders::default().name())]
    pub order: Orders,
    /// Lights that get shadow rays
    #[arg(long, value_parser = choice::<Lights>(),
          default_value = Lights::default().name())]
    pub lights: Lights,
    /// Longest pass over the rays; slower rows are timed on a sample of them [default: 200ms, 30ms
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

/// Memory limit of a structure.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Measuring")]
pub struct MemoryArgs {
    /// Memory limit of a structure; rows above it are shown as `out of memory` [default: half of
    /// the machine's memory, or of the control group's limit if that is less]
    #[arg(long, value_name = "BYTES", value_parser = quantity::bytes)]
    pub max_memory: Option<u64>,
}
