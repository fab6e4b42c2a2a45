//! `rtbench render` and `rtbench cost`.

use std::path::PathBuf;

use clap::Args;

use crate::args::parsers::scene_name;

/// `--shadows` for shadow rays that the structure answers.
pub const STRUCTURE_SHADOWS: &str = "structure";

#[derive(Debug, Clone, Args)]
pub struct RenderArgs {
    /// Scene name or file
    #[arg(value_parser = scene_name())]
    pub scene: String,
    /// Image to write: .png, or .exr for linear floats
    #[arg(short, long, value_name = "FILE", required_unless_present = "plan")]
    pub output: Option<PathBuf>,
    /// Print the effects of the scene, and the rays per pixel that each adds, instead of rendering
    #[arg(long)]
    pub plan: bool,
    /// Structure to trace with [default: wide-bvh, or the first]
    #[arg(short, long, alias = "structures", value_name = "STRUCTURE")]
    pub structure: Option<String>,
    /// Answer shadow rays by the structure, or by an occluder like light-buffer:resolution=256
    #[arg(long, value_name = "OCCLUDER", default_value = STRUCTURE_SHADOWS)]
    pub shadows: String,
    /// Width and height of the image
    #[arg(long, value_name = "PIXELS", default_value_t = 512,
          value_parser = measurement::settings::quantity::count(1..=16384))]
    pub size: u32,
    /// Number of threads [default: all]
    #[arg(short = 'j', long, value_name = "N",
          value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// How finely to sample.
    #[command(flatten)]
    pub sampling: SamplingArgs,
}

#[derive(Debug, Clone, Args)]
pub struct CostArgs {
    /// Scene name or file
    #[arg(value_parser = scene_name())]
    pub scene: String,
    /// Structures to trace with, a table each [default: wide-bvh, or the first]
    #[arg(short, long, alias = "structure", value_name = "STRUCTURE", value_delimiter = ',')]
    pub structures: Vec<String>,
    /// Width and height of the image
    #[arg(long, value_name = "PIXELS", default_value_t = 256,
          value_parser = measurement::settings::quantity::count(1..=16384))]
    pub size: u32,
    /// Number of threads that trace
    #[arg(short = 'j', long, value_name = "N", default_value_t = 1,
          value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: u16,
    /// Draw tests, steps and time of each pixel, structures side by side on one scale: tests.png,
    /// steps.png, time.png
    #[arg(long, value_name = "DIR")]
    pub heat_maps: Option<PathBuf>,
    /// How finely to sample.
    #[command(flatten)]
    pub sampling: SamplingArgs,
}

/// The factors of an image's cost beside its pixels. Those of effects that the scene does not call
/// for change nothing.
#[derive(Debug, Clone, Copy, Args)]
#[command(next_help_heading = "Sampling")]
pub struct SamplingArgs {
    /// Longest chain of rays; eye rays have depth 1
    #[arg(long, value_name = "N", default_value_t = 5,
          value_parser = clap::value_parser!(u32).range(1..=64))]
    pub depth: u32,
    /// Eye rays per pixel for antialiasing [default: the scene's, or 1]
    #[arg(long, value_name = "N", value_parser = measurement::settings::quantity::count(1..=65536))]
    pub supersamples: Option<u32>,
    /// Shadow rays per hit, for each light with a radius [default: the scene's, or 16]
    #[arg(long, value_name = "N", value_parser = measurement::settings::quantity::count(1..=65536))]
    pub shadow_samples: Option<u32>,
    /// Rays of the first rough mirror of a path [default: the scene's, or 16]
    #[arg(long, value_name = "N", value_parser = measurement::settings::quantity::count(1..=65536))]
    pub glossy_samples: Option<u32>,
    /// Eye rays per pixel for motion blur [default: the scene's, or 16]
    #[arg(long, value_name = "N", value_parser = measurement::settings::quantity::count(1..=65536))]
    pub temporal_samples: Option<u32>,
    /// Eye rays per pixel for depth of field [default: the scene's, or 16]
    #[arg(long, value_name = "N", value_parser = measurement::settings::quantity::count(1..=65536))]
    pub focal_samples: Option<u32>,
    /// Seed of the sample patterns
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
}
