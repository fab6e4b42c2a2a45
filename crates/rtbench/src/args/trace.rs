//! `rtbench trace`.

use std::path::PathBuf;

use clap::Args;
use measurement::settings::Precision;

use crate::args::parsers::{choice, scene_name};
use crate::args::plugins::PluginArgs;

/// `rtbench trace`.
#[derive(Debug, Clone, Args)]
pub struct TraceArgs {
    /// A scene
    #[arg(value_parser = scene_name())]
    pub scene: String,
    /// The rays: a file of `rays export`, or text with a ray a line: origin, t_min, direction,
    /// t_max, in decimal or hexadecimal (0x1.8p-1)
    #[arg(long, value_name = "FILE")]
    pub rays: PathBuf,
    /// Structures as for `run`
    #[arg(
        short,
        long,
        value_name = "STRUCTURE",
        value_delimiter = ',',
        required_unless_present = "plugin"
    )]
    pub structures: Vec<String>,
    /// Structures of yours.
    #[command(flatten)]
    pub plugins: PluginArgs,
    /// Write the hits of one structure to a file as `hits check` reads it [default: print them]
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// Arithmetic of primitives and rays
    #[arg(long, value_parser = choice::<Precision>(), default_value = Precision::default().name())]
    pub precision: Precision,
}
