//! Sets of scenes of a configuration, beside those that the program carries.

use std::collections::BTreeSet;

use scene_loading::source_names::{name_of_path, path_of_name};
use serde_json::{Map, Value};

use crate::config::file::Config;
use measurement::scenes::{KnownScene, LoadError, SceneSizes, SceneSource, ViewOptions};

/// A source of scenes with the sets of a configuration.
pub struct Configured<'a> {
    source: &'a dyn SceneSource,
    config: Option<&'a Config>,
    allow_outside: bool,
    view: ViewOptions,
}

impl<'a> Configured<'a> {
    /// The source, the configuration if there is one, and what all scenes are given.
    pub fn new(
        source: &'a dyn SceneSource,
        config: Option<&'a Config>,
        allow_outside: bool,
        view: ViewOptions,
    ) -> Self {
        Self { source, config, allow_outside, view }
    }

    /// What a name stands for: the names in its set, each in its place, else itself. A set may name
    /// sets; `within` has those that are being expanded, which stand for themselves: the name of a
    /// set of the program may be given to one that holds it.
    fn expand(&self, name: &str, within: &mut BTreeSet<String>, out: &mut Vec<String>) {
        let members = self.config.and_then(|config| config.set(name));
        match members {
            Some(members) if within.insert(name.to_owned()) => {
                for member in members {
                    self.expand(&member, within, out);
                }
                within.remove(name);
            }
            _ => out.push(name.to_owned()),
        }
    }
}

impl Config {
    /// The members of a set; files that lie beside the configuration by their paths.
    fn set(&self, name: &str) -> Option<Vec<String>> {
        let folder = self.path.parent();
        let member = |member: &String| {
            // names of scenes have neither dots nor separators
            let is_path = member.contains(['/', '\\', '.']);
            let beside = folder.filter(|_| is_path).map(|f| f.join(path_of_name(member)));
            beside.map_or_else(|| member.clone(), |path| name_of_path(path.as_os_str()))
        };
        let (_, members) = self.tables.sets.iter().find(|(key, _)| key.get_ref() == name)?;
        Some(members.get_ref().iter().map(member).collect())
    }

    /// The names of the sets.
    fn set_names(&self) -> impl Iterator<Item = &String> {
        self.tables.sets.keys().map(|key| key.get_ref())
    }
}

impl SceneSource for Configured<'_> {
    fn resolve(&self, names: &[String]) -> Result<Vec<Box<dyn KnownScene>>, LoadError> {
        let mut expanded = Vec::new();
        for name in names {
            self.expand(name, &mut BTreeSet::new(), &mut expanded);
        }
        let mut scenes = self.source.resolve(&expanded)?;
        if self.allow_outside {
            scenes.iter_mut().for_each(|scene| scene.allow_outside());
        }
        if !self.view.is_empty() {
            scenes.iter_mut().for_each(|scene| scene.set_view(&self.view));
        }
        Ok(scenes)
    }

    fn allows_outside(&self) -> bool {
        self.allow_outside
    }

    fn scenes(&self) -> Result<Vec<(String, String)>, LoadError> {
        self.source.scenes()
    }

    fn sizes(&self, name: &str) -> Result<SceneSizes, LoadError> {
        self.source.sizes(name)
    }

    fn sets(&self) -> Result<Vec<(String, Vec<String>)>, LoadError> {
        let mut sets = self.source.sets()?;
        if let Some(config) = self.config {
            sets.retain(|(name, _)| config.set(name).is_none());
            for name in config.set_names() {
                sets.push((name.clone(), config.set(name).unwrap_or_default()));
            }
        }
        Ok(sets)
    }

    /// Of the program's sets: one of the configuration hides that of its name, and has none.
    fn run_options(&self, set: &str, quick: bool) -> Result<Map<String, Value>, LoadError> {
        if self.config.is_some_and(|config| config.set(set).is_some()) {
            return Ok(Map::new());
        }
        self.source.run_options(set, quick)
    }
}
