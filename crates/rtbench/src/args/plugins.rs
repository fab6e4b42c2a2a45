//! Structures that come out of shared libraries.

use std::ffi::OsString;
use std::path::PathBuf;
use std::time::Duration;

use clap::Args;

/// Which plugins, and how they run.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Plugins")]
pub struct PluginArgs {
    /// A shared library with a structure of yours (rtbench.h): its row stands beside ours
    #[arg(long, value_name = "FILE")]
    pub plugin: Vec<PathBuf>,
    /// Run plugins in this process, not in one of their own: what ends a plugin ends the run
    #[arg(long, requires = "plugin")]
    pub in_process: bool,
    /// Longest time of a plugin's build, and of one of its calls that answer rays
    #[arg(long, value_name = "TIME", default_value = "60s", requires = "plugin",
          value_parser = measurement::settings::duration::parse)]
    pub plugin_limit: Duration,
}

impl PluginArgs {
    /// What names the same to another process of this program; nothing where there are none.
    pub fn arguments(&self) -> Vec<OsString> {
        self.arguments_for(&self.plugin)
    }

    /// The same settings with other files.
    pub fn arguments_for(&self, files: &[PathBuf]) -> Vec<OsString> {
        let files = files.iter().flat_map(|file| ["--plugin".into(), file.clone().into()]);
        let mut arguments: Vec<OsString> = files.collect();
        if !arguments.is_empty() {
            let limit = format!("{}ms", self.plugin_limit.as_millis().max(1));
            arguments.extend(["--plugin-limit".into(), limit.into()]);
            arguments.extend(self.in_process.then(|| "--in-process".into()));
        }
        arguments
    }
}

/// `rtbench child plugin`: what a run starts for each row of a plugin.
#[derive(Debug, Clone, Args)]
pub struct ServeArgs {
    /// The shared library
    #[arg(long)]
    pub file: PathBuf,
    /// Where the run listens
    #[arg(long)]
    pub socket: PathBuf,
}
