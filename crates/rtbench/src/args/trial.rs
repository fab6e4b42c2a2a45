//! `rtbench child build`: what [`measurement::rounds::trial`] starts.

use clap::Args;

use crate::args::parsers::{choice, scene_name};
use measurement::settings::Precision;

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
