//! Scenes with the camera, lights and permissions that the command line gives them.

use measurement::scenes::{KnownScene, LoadError, SceneSet, SceneSizes, SceneSource, ViewOptions};

/// A source whose scenes get the view of the command line instead of their own.
pub struct GivenView<'a> {
    source: &'a dyn SceneSource,
    allow_outside: bool,
    view: ViewOptions,
}

impl<'a> GivenView<'a> {
    pub fn new(source: &'a dyn SceneSource, allow_outside: bool, view: ViewOptions) -> Self {
        Self { source, allow_outside, view }
    }
}

impl SceneSource for GivenView<'_> {
    fn resolve(&self, names: &[String]) -> Result<Vec<Box<dyn KnownScene>>, LoadError> {
        let mut scenes = self.source.resolve(names)?;
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

    fn sets(&self) -> Result<Vec<SceneSet>, LoadError> {
        self.source.sets()
    }
}
