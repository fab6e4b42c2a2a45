//! `rtbench rays`: any program, by files.

use std::path::PathBuf;

use crate::args::measuring::PluginArgs;
use crate::args::parsers::{choice, scene_name};
use clap::{Args, Subcommand};
use measurement::settings::choice::Choice;
use measurement::settings::{Lights, MeasuringSettings, Precision};

#[derive(Debug, Clone, Subcommand)]
pub enum RaysAction {
    /// Write the rays of a scene, and its triangles, for another program
    Export(ExportRaysArgs),
    /// Trace rays from a file, and print or write the hits
    #[command(
        after_help = "Examples:\n  rtbench rays trace case.obj --rays case.rays -s brute-force,wide-bvh\n  rtbench rays trace kitchen --rays kitchen.rays -s wide-bvh -o kitchen.hits"
    )]
    Trace(TraceArgs),
    /// Compare another program's answers with ours: right, wrong, or different at an edge
    Check(CheckRaysArgs),
}

#[derive(Debug, Clone, Args)]
pub struct ExportRaysArgs {
    /// Scene of triangles
    #[arg(value_parser = scene_name())]
    pub scene: String,
    /// Kinds of rays: primary, shadow, reflected, refracted, diffuse [default: all]
    #[arg(long, value_name = "KIND", value_delimiter = ',', alias = "rays")]
    pub kind: Vec<String>,
    /// File to write rays to
    #[arg(short, long, value_name = "FILE", required_unless_present = "triangles")]
    pub output: Option<PathBuf>,
    /// File to write triangles to: nine f32 and a flag each
    #[arg(long, value_name = "FILE")]
    pub triangles: Option<PathBuf>,
    /// Format of the rays
    #[arg(long, value_parser = choice::<RayFormat>(), default_value = RayFormat::Rtbench.as_typed())]
    pub format: RayFormat,
    /// Width and height of the image
    #[arg(long, value_name = "PIXELS", default_value_t = 128,
          value_parser = clap::value_parser!(u32).range(1..=MeasuringSettings::LARGEST_SIZE.into()))]
    pub size: u32,
    /// Seed of the rays
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
    /// Lights that get shadow rays: every light that a hit faces, or the first light, from primary
    /// hits
    #[arg(long, value_parser = choice::<Lights>(), default_value = Lights::Each.name())]
    pub lights: Lights,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RayFormat {
    /// With a header, and with the interval of each ray.
    Rtbench,
    /// Six f32 per ray, without a header.
    Hagrid,
}

impl Choice for RayFormat {
    const ALL: &'static [(Self, &'static str, &'static str)] = &[
        (Self::Rtbench, "rtbench", "A header, then origin, t_min, direction, t_max of each ray"),
        (Self::Hagrid, "hagrid", "Origin and direction of each ray, no header, no interval"),
    ];
}

#[derive(Debug, Clone, Args)]
pub struct CheckRaysArgs {
    /// Scene whose rays the program answered
    #[arg(value_parser = scene_name())]
    pub scene: String,
    /// Answers: the header of the rays file, marked as hits, then t and id of each ray
    pub file: PathBuf,
    /// Add the program as a foreign row to the results of a run with these rays: its folder, from
    /// `run -o`
    #[arg(long, value_name = "DIR", requires = "name", requires = "time_ms")]
    pub into: Option<PathBuf>,
    /// Name of the program
    #[arg(long, requires = "into", value_parser = clap::builder::NonEmptyStringValueParser::new())]
    pub name: Option<String>,
    /// Time that the program reports for all rays of the file, milliseconds
    #[arg(long, value_name = "MS", requires = "into", value_parser = milliseconds)]
    pub time_ms: Option<f64>,
    /// Build time that the program reports, milliseconds
    #[arg(long, value_name = "MS", requires = "into", value_parser = milliseconds)]
    pub build_ms: Option<f64>,
}

/// Milliseconds as typed.
fn milliseconds(text: &str) -> Result<f64, String> {
    let number = text.parse::<f64>().ok().filter(|ms| *ms > 0.0 && *ms < 1e12);
    number.ok_or_else(|| "expected milliseconds, more than 0: 12.5".into())
}

#[derive(Debug, Clone, Args)]
pub struct TraceArgs {
    /// Scene to trace the rays in
    #[arg(value_parser = scene_name())]
    pub scene: String,
    /// Rays: a file of `rays export`, or text with one ray per line: origin, t_min, direction,
    /// t_max, in decimal or hexadecimal (0x1.8p-1)
    #[arg(long, value_name = "FILE")]
    pub rays: PathBuf,
    /// Structures as for `run`
    #[arg(short, long, alias = "structure", value_name = "STRUCTURE", value_delimiter = ',')]
    #[arg(required_unless_present = "plugin")]
    pub structures: Vec<String>,
    /// Write the hits of one structure to a file as `rays check` reads it [default: print them]
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// Floating-point precision of primitives and rays
    #[arg(long, value_parser = choice::<Precision>(), default_value = Precision::default().name())]
    pub precision: Precision,
    #[command(flatten)]
    pub plugins: PluginArgs,
}
