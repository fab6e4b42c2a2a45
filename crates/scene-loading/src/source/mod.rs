//! From a name on the command line to a scene: the catalogue, and what it hands out.

mod catalogue;
pub mod formats;
pub mod hash;
pub mod names;
mod scene_ref;
mod sizes;

pub use catalogue::SceneCatalogue;
pub use scene_ref::{LoadedScene, SceneRef};
pub use sizes::SceneSizes;
