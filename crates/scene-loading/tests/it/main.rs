//! All integration tests of the crate, as one program: each more would be linked on its own.

mod animation;
mod far_scenes;
mod fuzz_seeds;
mod gltf_extensions;
mod gltf_file;
mod gltf_leniency;
mod gltf_pose;
mod hard_cases;
mod hostile;
mod load_catalogue;
mod load_damaged;
mod load_effects;
mod load_gltf;
mod load_meshes;
mod load_nff;
mod load_obj;
mod load_pbrt;
mod load_textures;
mod own_scenes;
mod spd;
mod view;

use std::path::Path;

use scene_loading::source::formats::{ReadOptions, load_scene};
use scene_loading::{LoadError, Scene};

/// The scene of a file.
fn load(path: &Path) -> Result<Scene, LoadError> {
    load_scene(path, ReadOptions::default())
}
