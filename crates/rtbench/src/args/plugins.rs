//! Structures that come out of shared libraries.

use std::ffi::OsString;
use std::path::PathBuf;
use std::time::Duration;

use clap::Args;

/// Plugins, and how they run.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Plugins")]
pub struct PluginArgs {
    /// Measure a structure from this shared library (see rtbench.h) as an extra row
    #[arg(long, value_name = "FILE")]
    pub plugin: Vec<PathBuf>,
    /// Load plugins in-process (a plugin crash aborts the run)
    #[arg(long, requires = "plugin")]
    pub in_process: bool,
    /// Time limit of a plugin's build, and of each of its calls that answer rays
    #[arg(long, value_name = "TIME", default_value = "60s", requires = "plugin",
          value_parser = measurement::settings::duration::parse)]
    pub plugin_limit: Duration,
}

impl PluginArgs {
    /// Arguments that pass the plugins to another process of this program; empty without plugins.
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
    /// Shared library of the plugin
    #[arg(long)]
    pub file: PathBuf,
    /// Address at which the run listens
    #[arg(long)]
    pub socket: PathBuf,
}
