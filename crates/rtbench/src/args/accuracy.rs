//! `rtbench accuracy`.

use std::path::PathBuf;

use clap::Args;
use serde::{Deserialize, Serialize};

#[derive(Debug, Clone, Args, Serialize, Deserialize)]
pub struct AccuracyArgs {
    /// Axes [default: all]
    #[arg(value_name = "AXIS")]
    pub axes: Vec<String>,
    /// Scenes, sets or files [default: two of SPD and a modelled one, each axis its own]
    #[arg(long = "scene", value_name = "SCENE|SET", value_delimiter = ',')]
    pub scenes: Vec<String>,
    /// Few rounds, rays and samples: a first look
    #[arg(long)]
    pub quick: bool,
    /// Rounds: each times every variant of an axis once [default: 15, quick 5]
    #[arg(long, value_name = "N", value_parser = measurement::settings::quantity::count(3..=1000))]
    pub rounds: Option<u32>,
    /// Time the variants of each axis in so many fresh processes, one after the other
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = measurement::settings::quantity::count(1..=100))]
    pub processes: u32,
    /// Pixels across the image whose rays are traced, with as many more rays timed as it has pixels
    /// [default: 96, quick 32]
    #[arg(long, value_name = "PIXELS", value_parser = measurement::settings::quantity::count(8..=2048))]
    pub size: Option<u32>,
    /// Trials of an exact oracle for each variant [default: 100000, quick 10000]
    #[arg(long, value_name = "N", value_parser = measurement::settings::quantity::count(100..=100_000_000))]
    pub trials: Option<u32>,
    /// Seed of rays, aims, schedules and intervals
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
    /// Write accuracy.csv, accuracy.json, accuracy.md, summary.md, one plot per axis and images there
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
}
