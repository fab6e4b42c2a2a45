//! Arguments of the studies: `accuracy`, `animate`, `compare-tracers`, `explain`, `reproduce`, `verify`.

use crate::args::measuring::{MeasuringArgs, PluginArgs, RatioArgs};
use crate::args::parsers::{scene_name, threads};
use clap::{Args, Subcommand};
use measurement::settings::RunSettings;
use measurement::settings::quantity::{count, duration};
use serde::{Deserialize, Serialize};
use std::path::PathBuf;
use std::time::Duration;

#[derive(Debug, Clone, Args, Serialize, Deserialize)]
pub struct AccuracyArgs {
    /// Axes of accuracy to measure [default: all]
    #[arg(value_name = "AXIS")]
    pub axes: Vec<String>,
    /// Scenes, sets or files [default: two SPD scenes and a modelled one; some axes have their own]
    #[arg(long = "scene", value_name = "SCENE|SET", value_delimiter = ',')]
    pub scenes: Vec<String>,
    /// Use few rounds, rays and samples, for a first look
    #[arg(long)]
    pub quick: bool,
    /// Rounds; each times every variant of an axis once [default: 15, quick 5]
    #[arg(long, value_name = "N", value_parser = count(3..=1000))]
    pub rounds: Option<u32>,
    /// Time the variants of each axis in this many fresh processes, one after the other
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = count(1..=100))]
    pub processes: u32,
    /// Width and height of the image whose rays are traced; as many extra rays as pixels are timed
    /// [default: 96, quick 32]
    #[arg(long, value_name = "PIXELS", value_parser = count(8..=2048))]
    pub size: Option<u32>,
    /// Trials against an exact oracle per variant [default: 100000, quick 10000]
    #[arg(long, value_name = "N", value_parser = count(100..=100_000_000))]
    pub trials: Option<u32>,
    /// Seed of rays, targets, schedules and intervals
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
    /// Write accuracy.csv, accuracy.json, accuracy.md, summary.md, one plot per axis and images to
    /// DIR
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
}

#[derive(Debug, Clone, Args)]
pub struct AnimateArgs {
    /// A moving scene: generated (marbles, city:2; see `rtbench list animations`) or files:
    /// walk.glb, 'frame%04d.obj'
    #[arg(value_name = "ANIMATION", value_parser = scene_name())]
    pub scene: String,
    /// First and last frame, numbered from 0 [default: all]
    #[arg(long, value_name = "A..B", value_parser = frames)]
    pub frames: Option<[u32; 2]>,
    /// Structures, with settings if any: wide-bvh:update=refit [default: all, each with its
    /// defaults and with every other update method]
    #[arg(short, long, alias = "structure", value_name = "STRUCTURE", value_delimiter = ',')]
    pub structures: Vec<String>,
    /// Write animation.json, frames.csv, animate.md, animate.svg and strip.png there, after each
    /// frame anew
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    #[command(flatten)]
    pub measuring: MeasuringArgs,
}

/// `3..7` or `3`.
fn frames(text: &str) -> Result<[u32; 2], String> {
    let (first, last) = text.split_once("..").unwrap_or((text, text));
    let number = |text: &str| text.trim_start_matches('=').parse::<u32>();
    match (number(first), number(last)) {
        (Ok(first), Ok(last)) if first <= last => Ok([first, last]),
        _ => Err("expected the first and the last frame: 0..9".into()),
    }
}

#[derive(Debug, Clone, Args)]
pub struct CompareTracersArgs {
    /// Scene name or file
    #[arg(value_parser = scene_name())]
    pub scene: String,
    /// Tracers: whitted,cone,beam [default: all]
    #[arg(long, value_name = "TRACER", value_delimiter = ',')]
    pub tracers: Vec<String>,
    /// Leave out primitives of these kinds, which a tracer may not support: spheres,cones,polygons,
    /// triangles,patches
    #[arg(long, value_name = "KIND", value_delimiter = ',')]
    pub without: Vec<String>,
    /// Samples per pixel [default: 1,2,4,...,1024; with --quick 1,4,16,64,256]
    #[arg(long, value_name = "N", value_delimiter = ',', value_parser = count(1..=65536))]
    pub samples: Vec<u32>,
    /// Samples per pixel of each of the reference's two images [default: 4096; with --quick 1024]
    #[arg(long, value_name = "N", value_parser = count(1..=4_194_304))]
    pub reference_samples: Option<u32>,
    /// Structure that gives cones and beams their candidates: brute-force, uniform-grid,
    /// hashed-grid, bricked-grid or kd-tree, with settings if any
    #[arg(long, value_name = "STRUCTURE", default_value = "uniform-grid")]
    pub through: String,
    /// Width and height of the images [default: 64; with --quick 32]
    #[arg(long, value_name = "PIXELS", value_parser = count(1..=4096))]
    pub size: Option<u32>,
    /// Rounds; each renders every image once [default: 5; with --quick 3]
    #[arg(long, value_name = "N", value_parser = count(1..=10_000))]
    pub rounds: Option<u32>,
    /// Use small images and fewer samples, for a first look
    #[arg(long)]
    pub quick: bool,
    /// Number of threads that trace
    #[arg(short = 'j', long, value_name = "N", default_value_t = 1, value_parser = threads())]
    pub threads: u16,
    /// Write tracers.csv, tracers.json, tracers.md, tracers.svg and the images to DIR
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
}

#[derive(Debug, Clone, Args)]
pub struct ExplainArgs {
    /// Scenes, scene sets or scene files
    #[arg(value_name = "SCENE|SET", required = true, value_parser = scene_name())]
    pub scenes: Vec<String>,
    /// Row to explain, with its settings if any: kd-tree:kernel=block
    #[arg(short, long, alias = "structures", value_name = "ROW", default_value = "uniform-grid")]
    pub structure: String,
    /// Build and time each scene in that many processes, and take intervals over both levels
    #[arg(long, value_name = "N", default_value_t = 1,
          value_parser = clap::value_parser!(u32).range(1..=RunSettings::MOST_PROCESSES.into()))]
    pub processes: u32,
    /// Write explain.csv, explain.md and results.json to DIR
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    #[command(flatten)]
    pub measuring: RatioArgs,
}

/// Publications that can be reproduced.
#[derive(Debug, Clone, Subcommand)]
pub enum Publication {
    /// Havran and Sixta, Comparison of Hierarchical Grids, 1999, and Havran's octrees: all counters
    /// (about 20 minutes on two cores; `--structures uniform,recursive` takes three)
    Havran1999(HavranArgs),
    /// Zachmann's lecture, 2007: build and run times as ratios, the winners then and now
    Zachmann2007(ZachmannArgs),
}

#[derive(Debug, Clone, Args)]
pub struct HavranArgs {
    /// Scenes [default: all that the publication has]
    #[arg(long, value_name = "SCENE", value_delimiter = ',')]
    pub scenes: Vec<String>,
    /// Structures as the publication names them, `invariants` among them [default: all]
    #[arg(long, alias = "structure", value_name = "STRUCTURE", value_delimiter = ',')]
    pub structures: Vec<String>,
    /// Write havran1999.csv to DIR, one row per figure
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// Exit with code 1 if a figure differs for no known reason
    #[arg(long)]
    pub strict: bool,
}

#[derive(Debug, Clone, Args)]
pub struct ZachmannArgs {
    /// Scenes [default: all seven of the lecture]
    #[arg(long, value_name = "SCENE", value_delimiter = ',')]
    pub scenes: Vec<String>,
    /// Print the lecture's two tables as it has them, seconds by structure and scene, and ours
    /// below each
    #[arg(long)]
    pub as_published: bool,
    /// Write zachmann2007.csv to DIR, one row per scene and structure
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// How to measure; the reference is always uniform D=1.
    #[command(flatten)]
    pub measuring: MeasuringArgs,
}

#[derive(Debug, Clone, Args)]
pub struct VerifyArgs {
    /// Cases or groups of cases: G1,grid [default: all]
    #[arg(long, value_name = "CASE|GROUP", value_delimiter = ',')]
    pub cases: Vec<String>,
    /// Structures as for `run` [default: all with all their variants, and the negative control]
    #[arg(short, long, alias = "structure", value_name = "STRUCTURE", value_delimiter = ',')]
    pub structures: Vec<String>,
    /// Also check further settings of these structures, which otherwise only tests cover
    #[arg(long)]
    pub also_tested: bool,
    /// Rays per case and precision; the default takes more than 13 minutes of processor time
    #[arg(long, value_name = "N", default_value_t = 5000, value_parser = count(1..=100_000_000))]
    pub rays: u32,
    /// Seed of scenes and rays
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
    /// Number of threads [default: all]
    #[arg(short = 'j', long, value_name = "N", value_parser = threads())]
    pub threads: Option<u16>,
    /// Stop after this time: results so far are printed and written, marked as incomplete, with
    /// exit code 5 if nothing is wrong; Ctrl-C does the same, with 130
    #[arg(long, value_name = "TIME", value_parser = duration)]
    pub time_limit: Option<Duration>,
    /// Repeat one trial, given by a line that an earlier run printed
    #[arg(long, value_name = "LINE")]
    pub replay: Option<String>,
    /// Reduce the first failure of each structure, case and precision to the fewest triangles and
    /// one ray, and write it to DIR: OBJ, rays for `trace`, and a C program over rtbench.h
    #[arg(long, value_name = "DIR")]
    pub shrink: Option<PathBuf>,
    /// Write verify.json and verify.csv to DIR, rewritten after each case
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    #[command(flatten)]
    pub plugins: PluginArgs,
}

#[cfg(test)]
mod tests {
    use super::frames;

    #[test]
    fn frames_are_ranges_with_both_ends() {
        assert_eq!(frames("3..7"), Ok([3, 7]));
        assert_eq!(frames("3..=7"), Ok([3, 7]));
        assert_eq!(frames("4"), Ok([4, 4]));
        for wrong in ["", "7..3", "a..b", "-1..2", "1..2..3", "1.."] {
            assert!(frames(wrong).is_err(), "{wrong}");
        }
    }
}
