//! Stands in for the scene catalogue until it is merged: the SPD family only.

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
    pub licence: String,
}

/// As in `scene_loading`.
#[derive(Debug, Default)]
pub struct SceneCatalogue;

impl crate::scene_source::SceneSource for SceneCatalogue {
    fn expand(&self, name: &str) -> Result<Vec<String>, LoadError> {
        if name == "spd" {
            return Ok(procedural::SPD.iter().map(|s| s.name.to_owned()).collect());
        }
        let known: Vec<_> = procedural::SPD.iter().map(|s| s.name).collect();
        if known.contains(&name.split(':').next().unwrap_or_default()) {
            return Ok(vec![name.to_owned()]);
        }
        Err(LoadError::UnknownScene {
            name: name.to_owned(),
            suggestion: crate::suggest::hint(name, known.iter().copied()),
            valid: known.join(", "),
        })
    }

    fn load(&self, name: &str) -> Result<LoadedScene, LoadError> {
        let scene = procedural::generate(name).map_err(|e| LoadError::UnknownScene {
            name: name.to_owned(),
            suggestion: String::new(),
            valid: e.to_string(),
        })?;
        Ok(LoadedScene {
            scene,
            sha256: String::new(),
            source: "generated".into(),
            licence: "CC0".into(),
        })
    }

    fn scenes(&self) -> Vec<(String, String)> {
        procedural::SPD.iter().map(|s| (s.name.into(), s.summary.into())).collect()
    }

    fn sets(&self) -> Vec<(String, Vec<String>)> {
        vec![("spd".into(), procedural::SPD.iter().map(|s| s.name.into()).collect())]
    }

    fn fetch(&self, _: &str) -> Result<String, LoadError> {
        Ok("nothing to fetch".into())
    }
}
