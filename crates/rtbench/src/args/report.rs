//! `rtbench report`.

use std::path::PathBuf;

use clap::Args;

#[derive(Debug, Clone, Args)]
pub struct ReportArgs {
    /// The folder that `rtbench run -o DIR` wrote; what other commands left there is shown too. Several: runs, or
    /// machines, side by side
    #[arg(value_name = "DIR", required = true)]
    pub folders: Vec<PathBuf>,
    /// Where the page goes, `-` for stdout [default: DIR/report.html; of several folders report.html]
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// Write each plot of the page as an SVG file, too
    #[arg(long, value_name = "DIR")]
    pub plots: Option<PathBuf>,
    /// No pictures of scenes: they are rendered where DIR/pictures has none of them
    #[arg(long)]
    pub no_pictures: bool,
}
