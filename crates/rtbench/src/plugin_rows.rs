//! The plugins of a command line, and their rows among ours.

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use accel_core::structures::Entry;
use measurement::plan::Plan;
use measurement::record::SceneRecord;
use plugins::{Options, PluginError};
use scene_loading::source_hash::sha256_of_bytes;

use crate::args::PluginArgs;

/// This program's file on Linux, whatever became of its name.
const OWN: &str = "/proc/self/exe";

#[derive(Debug, Clone, Default)]
pub struct Plugins {
    /// Names, and the SHA-256 of their files.
    loaded: Vec<(&'static str, String)>,
    /// Arguments that pass them to another process of this program.
    pub arguments: Vec<OsString>,
}

impl Plugins {
    /// Loads the plugins that a command line names; also the structures there are with theirs after
    /// `ours`. No name is one of `taken`, or of ours. Their processes are started with `program`;
    /// rows whose process ended get a new one where that is asked for.
    pub fn load(
        args: &PluginArgs,
        ours: &[Entry],
        taken: impl Iterator<Item = &'static str> + Clone,
        program: Option<&PathBuf>,
        restarts: bool,
    ) -> Result<(Self, Vec<Entry>), PluginError> {
        let mut registry = ours.to_vec();
        let program = || match program {
            Some(program) if program.exists() => Ok(program.clone()),
            // a copy in memory (`--processes`) has no name; forks of it are it
            _ if Path::new(OWN).exists() => Ok(OWN.into()),
            _ => std::env::current_exe(),
        };
        let mut loaded = Vec::new();
        for file in &args.plugin {
            let read = |source| PluginError::Read { file: file.clone(), source };
            let (limit, in_process) = (args.plugin_limit, args.in_process);
            let program = program().map_err(read)?;
            let options = Options { program, limit, in_process, restarts };
            let bytes = std::fs::read(file).map_err(read)?;
            let sha256 = sha256_of_bytes(&bytes);
            let names = registry.iter().map(|entry| entry.info.name);
            let taken: Vec<&str> = names.chain(taken.clone()).collect();
            let entry = plugins::entry(file, sha256.clone(), &options, &taken)?;
            loaded.push((entry.info.name, sha256));
            registry.push(entry);
        }
        Ok((Self { loaded, arguments: args.arguments() }, registry))
    }

    pub fn names(&self) -> Vec<String> {
        self.loaded.iter().map(|(name, _)| (*name).to_owned()).collect()
    }

    /// Adds each to the rows asked for, unless they name it.
    pub fn add_rows(&self, structures: &mut Vec<String>) {
        if structures.is_empty() {
            return;
        }
        for (name, _) in &self.loaded {
            let is_named = |row: &String| {
                row == "all" || row.split([':', ' ']).find(|part| !part.is_empty()) == Some(name)
            };
            if !structures.iter().any(is_named) {
                structures.push((*name).to_owned());
            }
        }
    }

    /// None of them judges the answers of others.
    pub fn judge_nothing(&self, plan: &mut Plan<'_>) {
        plan.answers.retain(|row| self.loaded.iter().all(|(name, _)| *name != row.structure()));
    }

    /// The first that was another file when a scene was measured.
    pub fn changed_since(&self, scene: &SceneRecord) -> Option<&'static str> {
        let differs = |(name, sha256): &&(&'static str, String)| {
            let mut rows = scene.rows.iter().filter(|row| row.structure == *name);
            rows.any(|row| row.plugin.as_ref().is_some_and(|plugin| plugin.sha256 != *sha256))
        };
        self.loaded.iter().find(differs).map(|(name, _)| *name)
    }
}
