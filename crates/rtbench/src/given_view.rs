//! Scenes with the camera, lights and permissions that the command line gives them.

use serde_json::{Map, Value};

use measurement::scenes::{
    KnownScene, LoadError, SceneSizes, SceneSource, SetThreshold, ViewOptions,
};

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

    fn sets(&self) -> Result<Vec<(String, Vec<String>)>, LoadError> {
        self.source.sets()
    }

    fn run_options(&self, set: &str, quick: bool) -> Result<Map<String, Value>, LoadError> {
        self.source.run_options(set, quick)
    }

    fn check_thresholds(&self, set: &str) -> Result<Vec<SetThreshold>, LoadError> {
        self.source.check_thresholds(set)
    }
}
