//! `rtbench reproduce`.

use std::path::PathBuf;

use clap::{Args, Subcommand};

use crate::args::measuring::MeasuringArgs;

#[derive(Debug, Clone, Args)]
pub struct ReproduceArgs {
    #[command(subcommand)]
    pub publication: Publication,
}

/// What can be reproduced.
#[derive(Debug, Clone, Subcommand)]
pub enum Publication {
    /// Havran and Sixta, Comparison of Hierarchical Grids, 1999, and Havran's octrees: all counters
    /// (about 20 minutes on two cores; `--structures uniform,recursive` takes three)
    Havran1999(HavranArgs),
    /// Zachmann's lecture, 2007: build and run times as ratios, who won then and who wins now
    Zachmann2007(ZachmannArgs),
}

#[derive(Debug, Clone, Args)]
pub struct HavranArgs {
    /// Scenes [default: all that the publication has]
    #[arg(long, value_name = "SCENE", value_delimiter = ',')]
    pub scenes: Vec<String>,
    /// Structures as the publication names them, `invariants` among them [default: all]
    #[arg(long, value_name = "STRUCTURE", value_delimiter = ',')]
    pub structures: Vec<String>,
    /// Write one CSV row per figure
    #[arg(long, value_name = "FILE")]
    pub export_csv: Option<PathBuf>,
    /// Exit with 1 when a figure differs and nobody knows why
    #[arg(long)]
    pub strict: bool,
}

#[derive(Debug, Clone, Args)]
pub struct ZachmannArgs {
    /// Scenes [default: all seven of the lecture]
    #[arg(long, value_name = "SCENE", value_delimiter = ',')]
    pub scenes: Vec<String>,
    /// How to measure; the reference is always uniform D=1.
    #[command(flatten)]
    pub measuring: MeasuringArgs,
    /// Write one CSV row per scene and structure
    #[arg(long, value_name = "FILE")]
    pub export_csv: Option<PathBuf>,
}
