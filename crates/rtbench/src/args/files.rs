//! `rtbench rays` and `rtbench hits`: any program, by files.

use std::path::PathBuf;

use crate::args::parsers::{choice, scene_name};
use crate::args::plugins::PluginArgs;
use clap::{Args, Subcommand};
use measurement::settings::choice::Choice;
use measurement::settings::{Lights, MeasuringSettings, Precision, RunSettings};

#[derive(Debug, Clone, Args)]
pub struct RaysArgs {
    /// What to do with rays.
    #[command(subcommand)]
    pub action: RaysAction,
}

/// What to do with rays.
#[derive(Debug, Clone, Subcommand)]
pub enum RaysAction {
    /// Write the rays of a scene, and its triangles, for another program
    Export(ExportRaysArgs),
}

#[derive(Debug, Clone, Args)]
pub struct ExportRaysArgs {
    /// A scene of triangles
    #[arg(value_parser = scene_name())]
    pub scene: String,
    /// Kinds of rays: primary, shadow, reflected, refracted, diffuse [default: all]
    #[arg(long, value_name = "KIND", value_delimiter = ',', alias = "rays")]
    pub kind: Vec<String>,
    /// Where rays go
    #[arg(short, long, value_name = "FILE", required_unless_present = "triangles")]
    pub output: Option<PathBuf>,
    /// Where triangles go: nine f32 and a flag each
    #[arg(long, value_name = "FILE")]
    pub triangles: Option<PathBuf>,
    /// How rays are written
    #[arg(long, value_parser = choice::<RayFormat>(), default_value = RayFormat::Rtbench.as_typed())]
    pub format: RayFormat,
    /// Width and height of the image
    #[arg(long, value_name = "PIXELS", default_value_t = 128,
          value_parser = clap::value_parser!(u32).range(1..=MeasuringSettings::LARGEST_SIZE.into()))]
    pub size: u32,
    /// Seed of the rays
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
    /// Shadow rays run to each light that a hit faces, or from primary hits to the first
    #[arg(long, value_parser = choice::<Lights>(), default_value = Lights::Each.name())]
    pub lights: Lights,
}

/// How rays are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RayFormat {
    /// With a header and with the interval of each ray.
    Rtbench,
    /// Six f32 each.
    Hagrid,
}

impl Choice for RayFormat {
    const ALL: &'static [(Self, &'static str, &'static str)] = &[
        (Self::Rtbench, "rtbench", "A header, then origin, t_min, direction, t_max of each ray"),
        (Self::Hagrid, "hagrid", "Origin and direction of each ray, no header, no interval"),
    ];
}

#[derive(Debug, Clone, Args)]
pub struct HitsArgs {
    /// What to do with hits.
    #[command(subcommand)]
    pub action: HitsAction,
}

/// What to do with hits.
#[derive(Debug, Clone, Subcommand)]
pub enum HitsAction {
    /// Compare the answers of another program with ours: right, wrong, or different at an edge
    Check(CheckHitsArgs),
}

#[derive(Debug, Clone, Args)]
pub struct CheckHitsArgs {
    /// The scene whose rays they answer
    #[arg(value_parser = scene_name())]
    pub scene: String,
    /// The answers: the header of the rays with the name of hits, then t and id of each ray
    pub file: PathBuf,
    /// Keep it as a foreign row in the results of a run with these rays: its folder, from `run -o`
    #[arg(long, value_name = "DIR", requires = "name", requires = "time_ms")]
    pub into: Option<PathBuf>,
    /// The program's name
    #[arg(long, requires = "into", value_parser = clap::builder::NonEmptyStringValueParser::new())]
    pub name: Option<String>,
    /// How long it says that all rays of the file took, milliseconds
    #[arg(long, value_name = "MS", requires = "into", value_parser = milliseconds)]
    pub time_ms: Option<f64>,
    /// How long it says that its build took, milliseconds
    #[arg(long, value_name = "MS", requires = "into", value_parser = milliseconds)]
    pub build_ms: Option<f64>,
}

/// Milliseconds as typed.
fn milliseconds(text: &str) -> Result<f64, String> {
    let number = text.parse::<f64>().ok().filter(|ms| *ms > 0.0 && *ms < 1e12);
    number.ok_or_else(|| "expected milliseconds, more than 0: 12.5".into())
}

/// What a run would be asked for that has these rays.
pub fn settings_of(
    scene: &str,
    kinds: Vec<String>,
    size: u32,
    seed: u64,
    lights: Lights,
) -> RunSettings {
    RunSettings {
        scenes: vec![scene.to_owned()],
        measuring: MeasuringSettings {
            rays: kinds,
            size: Some(size),
            seed,
            lights,
            ..MeasuringSettings::default()
        },
        ..RunSettings::default()
    }
}

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
