//! Source of scenes: the catalogue of `scene-loading`, or a test's own.

use std::fmt::Debug;

use scene_loading::procedural::{SpecError, generator_of, generators};
pub use scene_loading::scene_set::{SceneSet, SetThreshold};

pub use scene_loading::{LoadError, LoadedScene, SceneCatalogue, SceneRef, ViewOptions};

/// A scene that is known but not loaded; a test may do something when it is loaded.
pub trait KnownScene: Debug + Send + Sync {
    fn known(&self) -> &SceneRef;

    fn known_mut(&mut self) -> &mut SceneRef;

    fn name(&self) -> &str {
        &self.known().name
    }

    /// Loads or generates it.
    fn load(&self) -> Result<LoadedScene, LoadError> {
        self.known().load()
    }
}

impl KnownScene for SceneRef {
    fn known(&self) -> &SceneRef {
        self
    }

    fn known_mut(&mut self) -> &mut SceneRef {
        self
    }
}

pub trait SceneSource {
    /// The scenes that names, names of sets and paths stand for, each once.
    fn resolve(&self, names: &[String]) -> Result<Vec<Box<dyn KnownScene>>, LoadError>;

    /// Returns whether sources of scene files may lie outside their folders.
    fn allows_outside(&self) -> bool {
        false
    }

    /// All scenes and sets that have a name. Read when asked for, so that a damaged file there is
    /// no obstacle to commands that need no scenes.
    fn catalogue(&self) -> Result<SceneCatalogue, LoadError> {
        SceneCatalogue::open(None)
    }
}

/// The catalogue that the program carries, with `./scenes` where there is one.
#[derive(Debug, Clone, Copy)]
pub struct InstalledScenes;

impl SceneSource for InstalledScenes {
    fn resolve(&self, names: &[String]) -> Result<Vec<Box<dyn KnownScene>>, LoadError> {
        let scenes = self.catalogue()?.resolve(names)?;
        scenes.iter().try_for_each(|scene| check_size(&scene.name))?;
        Ok(scenes.into_iter().map(|scene| Box::new(scene) as Box<dyn KnownScene>).collect())
    }
}

/// Every scene that has a name: name and title.
pub fn titles(catalogue: &SceneCatalogue) -> impl Iterator<Item = (&str, &str)> {
    let generated = generators().map(|entry| (entry.name, entry.summary));
    generated.chain(catalogue.scenes().map(|file| (&*file.name, &*file.title)))
}

/// A generated scene's size is checked when it is named, not when its turn comes.
fn check_size(spec: &str) -> Result<(), LoadError> {
    match generator_of(spec) {
        Err(error @ SpecError::BadSize { .. }) => {
            Err(LoadError::Procedural { spec: spec.to_owned(), message: error.to_string() })
        }
        _ => Ok(()),
    }
}
