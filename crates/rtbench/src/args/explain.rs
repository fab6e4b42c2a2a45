//! `rtbench explain`.

use std::path::PathBuf;

use clap::Args;
use measurement::settings::{MeasuringSettings, RunSettings};
use studies::explain::ExplainSettings;

use crate::args::measuring::MeasuringArgs;
use crate::args::memory::MemoryArgs;
use crate::args::parsers::scene_name;

#[derive(Debug, Clone, Args)]
pub struct ExplainArgs {
    /// Scenes, scene sets or scene files
    #[arg(value_name = "SCENE|SET", required = true, value_parser = scene_name())]
    pub scenes: Vec<String>,
    /// The row whose time is explained, with its settings if any: kd-tree:kernel=block
    #[arg(short, long, value_name = "ROW", default_value = "uniform-grid")]
    pub structure: String,
    #[command(flatten)]
    pub measuring: MeasuringArgs,
    /// How much memory a structure may take.
    #[command(flatten)]
    pub memory: MemoryArgs,
    /// Build and time each scene in that many processes, and take intervals over both levels
    #[arg(long, value_name = "N", default_value_t = 1,
          value_parser = clap::value_parser!(u32).range(1..=RunSettings::MOST_PROCESSES.into()))]
    pub processes: u32,
    /// Write one CSV row per scene, kind of ray and row or factor; - is standard output, instead of the
    /// tables
    #[arg(long, value_name = "FILE")]
    pub export_csv: Option<PathBuf>,
    /// Write the tables in Markdown; or -
    #[arg(long, value_name = "FILE")]
    pub export_markdown: Option<PathBuf>,
    /// Write everything, raw samples too, as JSON; or -
    #[arg(long, value_name = "FILE")]
    pub export_json: Option<PathBuf>,
    /// Write explain.csv, explain.md and results.json there
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
}

impl ExplainArgs {
    /// What was typed, but for the files to write.
    pub fn settings(&self) -> ExplainSettings {
        ExplainSettings {
            scenes: self.scenes.clone(),
            structure: self.structure.clone(),
            measuring: MeasuringSettings {
                max_memory: self.memory.max_memory,
                ..self.measuring.settings()
            },
            processes: self.processes,
        }
    }
}
