//! `rtbench sweep`.

use std::path::PathBuf;

use clap::Args;
use measurement::settings::MeasuringSettings;
use studies::sweep::SweepSettings;

use crate::args::measuring::MeasuringArgs;
use crate::args::memory::MemoryArgs;
use crate::args::parsers::scene_name;

/// `rtbench sweep`.
#[derive(Debug, Clone, Args)]
pub struct SweepArgs {
    /// Scenes, scene sets or scene files
    #[arg(value_name = "SCENE|SET", required = true, value_parser = scene_name())]
    pub scenes: Vec<String>,
    /// The structure, with its other settings if any: uniform-grid:resolution=woo
    #[arg(short, long, value_name = "STRUCTURE")]
    pub structure: String,
    /// The parameter
    #[arg(short, long, value_name = "PARAM")]
    pub parameter: String,
    /// Its values: none,array,hash
    #[arg(long, value_name = "VALUE", value_delimiter = ',',
          conflicts_with_all = ["from", "to", "steps", "linear"])]
    pub values: Vec<String>,
    /// Its first value, a number
    #[arg(
        long,
        value_name = "NUMBER",
        required_unless_present = "values",
        allow_negative_numbers = true
    )]
    pub from: Option<f64>,
    /// Its last value
    #[arg(
        long,
        value_name = "NUMBER",
        required_unless_present = "values",
        allow_negative_numbers = true
    )]
    pub to: Option<f64>,
    /// Number of values
    #[arg(long, value_name = "N", default_value_t = 9,
          value_parser = clap::value_parser!(u16).range(2..=1000))]
    pub steps: u16,
    /// Equal steps between values [default: equal ratios]
    #[arg(long)]
    pub linear: bool,
    /// Sets another parameter of the structure: resolution=woo
    #[arg(long = "set", value_name = "PARAM=VALUE")]
    pub settings: Vec<String>,
    /// How to measure.
    #[command(flatten)]
    pub measuring: MeasuringArgs,
    /// How much memory a structure may take.
    #[command(flatten)]
    pub memory: MemoryArgs,
    /// Print all columns [default: those that fit the terminal, or 120 characters]
    #[arg(long)]
    pub wide: bool,
    /// Write one CSV row per scene and value; - is standard output, instead of the tables
    #[arg(long, value_name = "FILE")]
    pub export_csv: Option<PathBuf>,
    /// Write a plot, one panel per scene; or -
    #[arg(long, value_name = "FILE")]
    pub export_svg: Option<PathBuf>,
    /// Write the tables in Markdown; or -
    #[arg(long, value_name = "FILE")]
    pub export_markdown: Option<PathBuf>,
    /// Write everything, raw samples too, as JSON; or -
    #[arg(long, value_name = "FILE")]
    pub export_json: Option<PathBuf>,
}

impl SweepArgs {
    /// What was typed, but for the files to write.
    pub fn settings(&self) -> SweepSettings {
        SweepSettings {
            scenes: self.scenes.clone(),
            structure: self.structure.clone(),
            parameter: self.parameter.clone(),
            values: self.values.clone(),
            from: self.from,
            to: self.to,
            steps: self.steps,
            linear: self.linear,
            settings: self.settings.clone(),
            measuring: MeasuringSettings {
                max_memory: self.memory.max_memory,
                ..self.measuring.settings()
            },
        }
    }
}
