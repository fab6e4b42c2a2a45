//! A scene that has a name, until it is loaded.

use std::path::PathBuf;

use crate::error::LoadError;
use crate::fetch::Places;
use crate::input::read::read_file;
use crate::scene::Scene;
use crate::scene_file::{SceneFile, Source};
use crate::second_opinion::{SecondOpinion, second_opinion};
use crate::source::described::DescribedScene;
use crate::source::embedded::generate;
use crate::source::formats::{ReadOptions, load_scene};
use crate::source::hash::sha256_of_scene;
use crate::view_options::{ViewOptions, light_if_dark};

/// A scene that is known but not loaded.
#[derive(Debug, Clone, PartialEq)]
pub struct SceneRef {
    /// Name in tables: `balls:5`, `kitchen`, the stem of a path.
    pub name: String,
    pub(crate) from: SceneOrigin,
    /// View and lights instead of the scene's own.
    pub view: ViewOptions,
    /// Files that its file names may lie outside its folder.
    outside: bool,
}

#[derive(Debug, Clone, PartialEq)]
pub(crate) enum SceneOrigin {
    Spd(String),
    File(PathBuf),
    Described(Box<DescribedScene>),
}

/// A scene in memory, and what a result has to say about its origin.
#[derive(Debug, Clone, PartialEq)]
pub struct LoadedScene {
    pub scene: Scene,
    /// Hash of the loaded scene: [`sha256_of_scene`].
    pub sha256: String,
    /// Origin in words: `generated: balls:4`, `obvhs 0.4.0: assets/...`.
    pub source: String,
    /// Licence of the geometry, where known.
    pub licence: Option<String>,
}

impl SceneRef {
    pub(crate) fn new(name: impl Into<String>, from: SceneOrigin) -> Self {
        Self { name: name.into(), from, view: ViewOptions::default(), outside: false }
    }

    /// The description it was resolved from, unless it is a plain file or generated.
    pub fn description(&self) -> Option<&SceneFile> {
        match &self.from {
            SceneOrigin::Described(described) => Some(&described.file),
            SceneOrigin::Spd(_) | SceneOrigin::File(_) => None,
        }
    }

    /// Lets the source of a scene file lie outside its folder, as only files of one's own should.
    pub fn allow_outside(&mut self) {
        self.outside = true;
        if let SceneOrigin::Described(described) = &mut self.from {
            described.outside = true;
        }
    }

    /// Loads or generates the scene. One without lights gets one at the eye, with a warning, unless
    /// its scene file says that it has none (`"lights": []`). One that is far from the origin of
    /// its coordinates is moved near it: [`Scene::origin`].
    ///
    /// # Errors
    /// [`LoadError::NotFetched`] when its package is not on this machine,
    /// [`LoadError::HashMismatch`], or the error of the loader, of the generator or of
    /// [`ViewOptions::apply`].
    pub fn load(&self) -> Result<LoadedScene, LoadError> {
        self.load_from(&Places::from_env())
    }

    /// [`SceneRef::load`] with the folders of packages given.
    ///
    /// # Errors
    /// As [`SceneRef::load`].
    pub fn load_from(&self, places: &Places) -> Result<LoadedScene, LoadError> {
        let (mut scene, source, licence) = match &self.from {
            SceneOrigin::Spd(spec) => {
                (generate(spec)?, format!("generated: {spec}"), Some("CC0-1.0 (SPD)".to_string()))
            }
            SceneOrigin::File(path) => {
                let options = ReadOptions { outside: self.outside, ..ReadOptions::default() };
                let scene = load_scene(path, options)?;
                (scene, path.display().to_string(), None)
            }
            SceneOrigin::Described(described) => {
                let (scene, source) = described.load(places)?;
                (scene, source, described.file.licence.clone())
            }
        };
        scene.name.clone_from(&self.name);
        self.view.apply(&mut scene)?;
        if self.description().is_none_or(|file| file.lights.is_none()) {
            light_if_dark(&mut scene);
        }
        scene.bring_near();
        Ok(LoadedScene { sha256: sha256_of_scene(&scene), scene, source, licence })
    }

    /// Second opinion of another reader on the scene's file; `None` for scenes without one.
    ///
    /// # Errors
    /// As [`SceneRef::load`].
    pub fn second_opinion(&self) -> Result<Option<SecondOpinion>, LoadError> {
        let path = match &self.from {
            SceneOrigin::Spd(_) => None,
            SceneOrigin::File(path) => Some(path.clone()),
            SceneOrigin::Described(described) => described.source_path(&Places::from_env())?,
        };
        path.map(|path| second_opinion(&path, read_file(&path)?)).transpose()
    }

    /// Brings the scene's package to this machine and checks the file; returns its path, or
    /// `None` for scenes that need no package.
    ///
    /// # Errors
    /// Those of [`Places::fetch`], and [`LoadError::HashMismatch`].
    pub fn fetch(&self) -> Result<Option<PathBuf>, LoadError> {
        let SceneOrigin::Described(described) = &self.from else { return Ok(None) };
        let Source::Crate(asset) = &described.file.source else { return Ok(None) };
        let path = Places::from_env().fetch(asset)?;
        described.check_hash(&path, &read_file(&path)?)?;
        Ok(Some(path))
    }
}
