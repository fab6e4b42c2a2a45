//! `rtbench animate`.

use std::path::PathBuf;

use clap::Args;
use measurement::settings::MeasuringSettings;
use studies::animate::AnimateSettings;

use crate::args::measuring::MeasuringArgs;
use crate::args::memory::MemoryArgs;
use crate::args::parsers::scene_name;

#[derive(Debug, Clone, Args)]
pub struct AnimateArgs {
    /// A scene that moves, generated (marbles, city:2; see `rtbench list animations`) or of files:
    /// walk.glb, 'frame%04d.obj'
    #[arg(value_name = "ANIMATION", value_parser = scene_name())]
    pub scene: String,
    /// First and last frame, numbered from 0 [default: all]
    #[arg(long, value_name = "A..B", value_parser = frames)]
    pub frames: Option<[u32; 2]>,
    /// Structures, each with its settings if any: wide-bvh:update=refit [default: each at its defaults, and
    /// with each other way to update it]
    #[arg(short, long, value_name = "STRUCTURE", value_delimiter = ',')]
    pub structures: Vec<String>,
    /// Overrides a default of a structure: uniform-grid.density=4
    #[arg(long = "set", value_name = "STRUCTURE.PARAM=VALUE")]
    pub overrides: Vec<String>,
    #[command(flatten)]
    pub measuring: MeasuringArgs,
    /// How much memory a structure may take.
    #[command(flatten)]
    pub memory: MemoryArgs,
    /// Print all columns [default: those that fit the terminal, or 120 characters]
    #[arg(long)]
    pub wide: bool,
    /// Write animation.json, frames.csv, animate.md, animate.svg and strip.png there, after each frame anew
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
}

impl AnimateArgs {
    /// What was typed, but for the scene and the files to write.
    pub fn settings(&self) -> AnimateSettings {
        AnimateSettings {
            frames: self.frames,
            structures: self.structures.clone(),
            overrides: self.overrides.clone(),
            measuring: MeasuringSettings {
                max_memory: self.memory.max_memory,
                ..self.measuring.settings()
            },
        }
    }
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
