//! `rtbench profile`.

use std::path::PathBuf;

use clap::Args;

/// `rtbench profile`.
#[derive(Debug, Clone, Args)]
pub struct ProfileArgs {
    /// Results: the JSON file of a run, or the folder of `run -o`
    #[arg(value_name = "RESULTS")]
    pub results: PathBuf,
    /// Scenes [default: all of the results]
    #[arg(long, value_name = "SCENE", value_delimiter = ',')]
    pub scene: Vec<String>,
    /// Structures or rows [default: the three that trace fastest over all scenes]
    #[arg(short, long, value_name = "ROW", value_delimiter = ',')]
    pub structures: Vec<String>,
    /// Neighbouring rays of each kind that are counted, at most
    #[arg(long, value_name = "N", default_value = "16k",
          value_parser = measurement::settings::quantity::count(64..=1_000_000))]
    pub rays: u32,
    /// Write the tables in Markdown
    #[arg(long, value_name = "FILE")]
    pub export_markdown: Option<PathBuf>,
}
