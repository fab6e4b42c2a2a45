//! Stands in for the scene catalogue until it is merged: the SPD family only.

use std::path::{Path, PathBuf};

use scene_loading::{Scene, procedural};

/// As in `scene_loading`.
#[derive(Debug, thiserror::Error)]
pub enum LoadError {
    /// No scene, set or file of that name.
    #[error("unknown scene `{name}`{suggestion}; valid: {valid}")]
    UnknownScene {
        /// The name as given.
        name: String,
        /// ` (did you mean ...?)` or empty.
        suggestion: String,
        /// All valid names and forms.
        valid: String,
    },
}

/// As in `scene_loading`.
#[derive(Debug)]
pub struct LoadedScene {
    /// The scene.
    pub scene: Scene,
    /// Hash of its source.
    pub sha256: String,
    /// Where it comes from.
    pub source: String,
    /// Under which licence.
    pub licence: Option<String>,
}

/// As in `scene_loading`.
#[derive(Debug, Default)]
pub struct SceneCatalogue;

/// As in `scene_loading`.
#[derive(Debug)]
pub struct SceneRef {
    /// Name.
    pub name: String,
}

/// As in `scene_loading`.
#[derive(Debug)]
pub struct SceneFile {
    pub name: String,
    pub title: String,
}

/// As in `scene_loading`.
#[derive(Debug)]
pub struct SceneSet {
    pub name: String,
    pub scenes: Vec<String>,
}

impl SceneCatalogue {
    pub fn open(_: Option<&Path>) -> Result<Self, LoadError> {
        Ok(Self)
    }

    pub fn resolve(&self, names: &[String]) -> Result<Vec<SceneRef>, LoadError> {
        let known: Vec<_> = procedural::SPD.iter().map(|s| s.name).collect();
        let mut all = Vec::new();
        for name in names {
            if name == "spd" {
                all.extend(known.iter().map(|s| SceneRef { name: (*s).to_owned() }));
            } else if known.contains(&name.split(':').next().unwrap_or_default()) {
                all.push(SceneRef { name: name.clone() });
            } else {
                return Err(LoadError::UnknownScene {
                    name: name.to_owned(),
                    suggestion: crate::suggest::hint(name, known.iter().copied()),
                    valid: known.join(", "),
                });
            }
        }
        Ok(all)
    }

    pub fn scenes(&self) -> impl Iterator<Item = &SceneFile> {
        std::iter::empty()
    }

    pub fn sets(&self) -> impl Iterator<Item = &SceneSet> {
        std::iter::empty()
    }
}

impl SceneRef {
    pub fn load(&self) -> Result<LoadedScene, LoadError> {
        let scene = procedural::generate(&self.name).map_err(|e| LoadError::UnknownScene {
            name: self.name.clone(),
            suggestion: String::new(),
            valid: e.to_string(),
        })?;
        let (sha256, source) = (String::new(), "generated".into());
        Ok(LoadedScene { scene, sha256, source, licence: None })
    }

    pub fn fetch(&self) -> Result<Option<PathBuf>, LoadError> {
        Ok(None)
    }
}
