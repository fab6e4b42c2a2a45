//! Source of scenes: the catalogue of `scene-loading`, or a test's own.

use std::fmt::Debug;
use std::path::PathBuf;

use scene_loading::procedural::{SpecError, generators};
pub use scene_loading::scene_set::{SceneSet, SetThreshold};

pub use scene_loading::{
    LoadError, LoadedScene, SceneCatalogue, SceneRef, SceneSizes, ViewOptions,
};

/// A scene that is known but not loaded.
pub trait KnownScene: Debug + Send + Sync {
    fn name(&self) -> &str;

    /// Loads or generates it.
    fn load(&self) -> Result<LoadedScene, LoadError>;

    /// Report of another reader on its file, line by line; empty without such a reader.
    fn second_opinion(&self) -> Result<Vec<String>, LoadError> {
        Ok(Vec::new())
    }

    /// Reads it even where its file names sources outside its folder.
    fn allow_outside(&mut self) {}

    /// Gives it a view and lights instead of its own.
    fn set_view(&mut self, _view: &ViewOptions) {}

    /// Overrides of its view and lights.
    fn view(&self) -> ViewOptions {
        ViewOptions::default()
    }

    /// Brings what it needs to this machine; the path, or none when it needs nothing.
    fn fetch(&self) -> Result<Option<PathBuf>, LoadError> {
        Ok(None)
    }
}

pub trait SceneSource {
    /// The scenes that names, names of sets and paths stand for, each once.
    fn resolve(&self, names: &[String]) -> Result<Vec<Box<dyn KnownScene>>, LoadError>;

    /// Returns whether sources of scene files may lie outside their folders.
    fn allows_outside(&self) -> bool {
        false
    }

    /// Every scene that has a name: name and title.
    fn scenes(&self) -> Result<Vec<(String, String)>, LoadError> {
        Ok(Vec::new())
    }

    /// The sizes of a scene.
    ///
    /// # Errors
    /// [`LoadError::NoSizes`] for what comes in one size, and for unknown names.
    fn sizes(&self, name: &str) -> Result<SceneSizes, LoadError> {
        Err(LoadError::NoSizes { name: name.to_owned(), valid: "none".to_owned() })
    }

    fn sets(&self) -> Result<Vec<SceneSet>, LoadError> {
        Ok(Vec::new())
    }

    fn set(&self, name: &str) -> Result<Option<SceneSet>, LoadError> {
        Ok(self.sets()?.into_iter().find(|set| set.name == name))
    }
}

/// The catalogue that the program carries, with `./scenes` where there is one. Read when asked
/// for, so that a damaged file there is no obstacle to commands that need no scenes.
#[derive(Debug, Clone, Copy)]
pub struct InstalledScenes;

impl SceneSource for InstalledScenes {
    fn resolve(&self, names: &[String]) -> Result<Vec<Box<dyn KnownScene>>, LoadError> {
        let scenes = SceneCatalogue::open(None)?.resolve(names)?;
        scenes.iter().try_for_each(|scene| check_size(&scene.name))?;
        Ok(scenes.into_iter().map(|scene| Box::new(scene) as Box<dyn KnownScene>).collect())
    }

    fn scenes(&self) -> Result<Vec<(String, String)>, LoadError> {
        let catalogue = SceneCatalogue::open(None)?;
        let generated = generators().map(|s| (s.name.to_owned(), s.summary.to_owned()));
        let described = catalogue.scenes().map(|s| (s.name.clone(), s.title.clone()));
        Ok(generated.chain(described).collect())
    }

    fn sizes(&self, name: &str) -> Result<SceneSizes, LoadError> {
        SceneCatalogue::open(None)?.sizes(name)
    }

    fn sets(&self) -> Result<Vec<SceneSet>, LoadError> {
        Ok(SceneCatalogue::open(None)?.sets().cloned().collect())
    }
}

impl KnownScene for SceneRef {
    fn name(&self) -> &str {
        &self.name
    }

    fn load(&self) -> Result<LoadedScene, LoadError> {
        self.load()
    }

    fn allow_outside(&mut self) {
        self.allow_outside();
    }

    fn set_view(&mut self, view: &ViewOptions) {
        self.view = view.clone();
    }

    fn view(&self) -> ViewOptions {
        self.view.clone()
    }

    fn second_opinion(&self) -> Result<Vec<String>, LoadError> {
        Ok(self.second_opinion()?.map(|opinion| opinion.lines()).unwrap_or_default())
    }

    fn fetch(&self) -> Result<Option<PathBuf>, LoadError> {
        self.fetch()
    }
}

/// A generated scene's size is checked when it is named, not when its turn comes.
fn check_size(spec: &str) -> Result<(), LoadError> {
    let Some((name, size)) = spec.split_once(':') else { return Ok(()) };
    let Some(family) = generators().find(|family| family.name == name) else { return Ok(()) };
    if size.parse().is_ok_and(|size| (1..=family.max_size).contains(&size)) {
        return Ok(());
    }
    let error = SpecError::BadSize {
        name: family.name,
        size: size.to_owned(),
        max_size: family.max_size,
        default_size: family.default_size,
    };
    Err(LoadError::Procedural { spec: spec.to_owned(), message: error.to_string() })
}
