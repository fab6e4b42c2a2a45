//! `rtbench render` and `rtbench cost`.

use std::path::PathBuf;
use std::str::FromStr;

use clap::Args;
use measurement::settings::choice;
use measurement::settings::quantity::count;
use scene_loading::SampleWishes;

use crate::args::parsers::{scene_name, threads};

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
    #[arg(long, value_name = "PIXELS", default_value_t = 512, value_parser = count(1..=16384))]
    pub size: u32,
    /// Number of threads [default: all]
    #[arg(short = 'j', long, value_name = "N", value_parser = threads())]
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
    #[arg(long, value_name = "PIXELS", default_value_t = 256, value_parser = count(1..=16384))]
    pub size: u32,
    /// Number of threads that trace
    #[arg(short = 'j', long, value_name = "N", default_value_t = 1, value_parser = threads())]
    pub threads: u16,
    /// Draw tests, steps and time of each pixel, structures side by side on one scale: tests.svg,
    /// steps.svg, time.svg
    #[arg(long, value_name = "DIR")]
    pub heat_maps: Option<PathBuf>,
    /// How finely to sample.
    #[command(flatten)]
    pub sampling: SamplingArgs,
}

/// The factors of an image's cost beside its pixels. Those of effects that the scene does not call
/// for change nothing.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Sampling")]
pub struct SamplingArgs {
    /// Longest chain of rays; eye rays have depth 1
    #[arg(long, value_name = "N", default_value_t = 5,
          value_parser = clap::value_parser!(u32).range(1..=64))]
    pub depth: u32,
    /// Samples of an effect, 1 to 65536: supersamples=4,shadow=16,glossy=16,temporal=16,focal=16
    /// [default: the scene's, or 1 supersample and 16 of the others]
    #[arg(long, value_name = "EFFECT=N", value_delimiter = ',')]
    pub samples: Vec<EffectSamples>,
}

/// The number of samples of one effect, by its name in scene files.
#[derive(Debug, Clone, Copy)]
pub struct EffectSamples {
    /// Place of the number among the wishes.
    place: fn(&mut SampleWishes) -> &mut Option<u32>,
    count: u32,
}

/// Effects by their names in scene files, with the rays that are counted.
type NamedEffect = (&'static str, fn(&mut SampleWishes) -> &mut Option<u32>);
const EFFECTS: [NamedEffect; 5] = [
    ("supersamples", |wishes| &mut wishes.supersamples),
    ("shadow", |wishes| &mut wishes.shadow),
    ("glossy", |wishes| &mut wishes.glossy),
    ("temporal", |wishes| &mut wishes.temporal),
    ("focal", |wishes| &mut wishes.focal),
];

impl FromStr for EffectSamples {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (name, number) = text.split_once('=').unwrap_or((text, ""));
        let Some((_, place)) = EFFECTS.iter().find(|(known, _)| *known == name) else {
            let valid = EFFECTS.map(|(name, _)| name);
            let hint = choice::hint(name, valid);
            return Err(format!("unknown effect '{name}'{hint}; valid: {}", valid.join(", ")));
        };
        let count = count(1..=65536)(number)?;
        Ok(Self { place: *place, count })
    }
}

impl SamplingArgs {
    pub fn wishes(&self) -> SampleWishes {
        let mut wishes = SampleWishes::default();
        for EffectSamples { place, count } in &self.samples {
            *place(&mut wishes) = Some(*count);
        }
        wishes
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_are_counted_by_effect() {
        let samples: Vec<EffectSamples> =
            ["glossy=8", "supersamples=2", "glossy=1k"].map(|text| text.parse().unwrap()).into();
        let wishes = SamplingArgs { depth: 5, samples }.wishes();
        assert_eq!(
            (wishes.supersamples, wishes.glossy, wishes.shadow),
            (Some(2), Some(1000), None)
        );
        for wrong in ["", "glossy", "glossy=0", "glossy=70k", "glosy=8", "8"] {
            assert!(wrong.parse::<EffectSamples>().is_err(), "{wrong}");
        }
        let error = "glosy=8".parse::<EffectSamples>().unwrap_err();
        assert!(error.contains("did you mean 'glossy'?"), "{error}");
    }
}
