//! The structures of a run with those of its plugins among them.

use accel_core::structures::Entry;
use measurement::record::SceneRecord;
use measurement::settings::RunSettings;
use plugins::{Options, PluginError};
use scene_loading::source_hash::sha256_of_bytes;

use crate::args::PluginArgs;
use crate::context::Context;
use crate::error::Error;

/// The structures there are for a run.
pub struct WithPlugins {
    /// Ours, then those of plugins.
    pub registry: Vec<Entry>,
    /// Names of plugins, and the SHA-256 of their files.
    plugins: Vec<(&'static str, String)>,
}

impl WithPlugins {
    /// Loads the plugins that a command line names.
    ///
    /// # Errors
    /// [`Error::Plugin`] for the first that cannot be used.
    pub fn load(context: &Context<'_>, args: &PluginArgs) -> Result<Self, Error> {
        let mut registry = context.registry.to_vec();
        let mut plugins = Vec::new();
        for file in &args.plugin {
            let read = |source| PluginError::Read { file: file.clone(), source };
            let program = context.environment.program.clone();
            let options = Options {
                program: program.map_or_else(std::env::current_exe, Ok).map_err(read)?,
                limit: args.plugin_limit,
                in_process: args.in_process,
            };
            let bytes = std::fs::read(file).map_err(read)?;
            let sha256 = sha256_of_bytes(&bytes);
            let occluders = context.occluders.iter().map(|entry| entry.info.name);
            let taken: Vec<&str> =
                registry.iter().map(|entry| entry.info.name).chain(occluders).collect();
            let entry = plugins::entry(file, sha256.clone(), &options, &taken)?;
            plugins.push((entry.info.name, sha256));
            registry.push(entry);
        }
        Ok(Self { registry, plugins })
    }

    /// Adds each plugin to the rows asked for, unless they name it.
    pub fn add_rows(&self, settings: &mut RunSettings) {
        if settings.structures.is_empty() {
            return;
        }
        for (name, _) in &self.plugins {
            let is_named = |row: &String| {
                row == "all" || row.split([':', ' ']).find(|part| !part.is_empty()) == Some(name)
            };
            if !settings.structures.iter().any(is_named) {
                settings.structures.push((*name).to_owned());
            }
        }
    }

    /// Whether a structure is of a plugin.
    pub fn is_plugin(&self, structure: &str) -> bool {
        self.plugins.iter().any(|(name, _)| *name == structure)
    }

    /// The first plugin that was another file when a scene was measured.
    pub fn changed_since(&self, scene: &SceneRecord) -> Option<&'static str> {
        let differs = |(name, sha256): &&(&'static str, String)| {
            let mut rows = scene.rows.iter().filter(|row| row.structure == *name);
            rows.any(|row| row.plugin.as_ref().is_some_and(|plugin| plugin.sha256 != *sha256))
        };
        self.plugins.iter().find(differs).map(|(name, _)| *name)
    }
}
