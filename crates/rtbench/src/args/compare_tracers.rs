//! `rtbench compare-tracers`.

use std::path::PathBuf;

use clap::Args;

use crate::args::parsers::scene_name;

#[derive(Debug, Clone, Args)]
pub struct CompareTracersArgs {
    /// A scene's name or file
    #[arg(value_parser = scene_name())]
    pub scene: String,
    /// Tracers: whitted,cone,beam [default: all]
    #[arg(long, value_name = "TRACER", value_delimiter = ',')]
    pub tracers: Vec<String>,
    /// Leave out primitives of these kinds, which a tracer may refuse: spheres,cones,polygons,
    /// triangles,patches
    #[arg(long, value_name = "KIND", value_delimiter = ',')]
    pub without: Vec<String>,
    /// Samples per pixel [default: 1,2,4,...,1024; with --quick 1,4,16,64,256]
    #[arg(long, value_name = "N", value_delimiter = ',',
          value_parser = measurement::settings::quantity::count(1..=65536))]
    pub samples: Vec<u32>,
    /// Samples per pixel of each of the reference's two images [default: 4096; with --quick 1024]
    #[arg(long, value_name = "N", value_parser = measurement::settings::quantity::count(1..=4_194_304))]
    pub reference_samples: Option<u32>,
    /// The structure that rays are traced through [default: obvhs-cwbvh, or the first]
    #[arg(short, long, value_name = "STRUCTURE")]
    pub structure: Option<String>,
    /// The structure that cones and beams ask for candidates: brute-force, uniform-grid,
    /// hashed-grid, bricked-grid or kd-tree, with settings if any
    #[arg(long, value_name = "STRUCTURE", default_value = "uniform-grid")]
    pub through: String,
    /// Width and height of the images [default: 64; with --quick 32]
    #[arg(long, value_name = "PIXELS", value_parser = measurement::settings::quantity::count(1..=4096))]
    pub size: Option<u32>,
    /// Longest chain of rays; eye rays have depth 1
    #[arg(long, value_name = "N", default_value_t = 5,
          value_parser = clap::value_parser!(u32).range(1..=64))]
    pub depth: u32,
    /// Rounds: each makes every image once [default: 5; with --quick 3]
    #[arg(long, value_name = "N", value_parser = measurement::settings::quantity::count(1..=10_000))]
    pub rounds: Option<u32>,
    /// Small images and fewer samples: a first look
    #[arg(long)]
    pub quick: bool,
    /// Threads that trace
    #[arg(short = 'j', long, value_name = "N", default_value_t = 1,
          value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: u16,
    /// Seed of samples, schedules and intervals
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
    /// Write tracers.csv, tracers.json, tracers.md, tracers.svg and the images there
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
}
