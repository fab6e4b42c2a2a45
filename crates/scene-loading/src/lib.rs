//! Scenes for `rtbench`: one type in f64, loaders for NFF, OBJ, glTF and JSON scene files, and
//! the Standard Procedural Databases generated in code.

// What a file says can make nothing panic. Generators and the tessellator index lists of their
// own making.
#![cfg_attr(
    not(test),
    deny(
        clippy::unwrap_used,
        clippy::expect_used,
        clippy::indexing_slicing,
        clippy::panic,
        clippy::unreachable
    )
)]

pub mod error;
pub mod fetch;
pub mod gltf;
mod gltf_buffers;
mod gltf_materials;
mod gltf_nodes;
mod gltf_textures;
pub mod info;
pub mod nff;
mod nff_tokens;
pub mod obj;
pub mod obj_export;
mod obj_material;
mod obj_polygon;
mod obj_scan;
mod obj_textures;
#[allow(clippy::indexing_slicing, clippy::expect_used)]
pub mod procedural;
pub mod progress;
pub mod scene;
mod scene_appearance;
pub mod scene_file;
mod scene_file_numbers;
pub mod scene_file_shapes;
pub mod scene_set;
mod scene_shapes;
mod scene_view;
pub mod source;
mod source_embedded;
pub mod source_formats;
pub mod source_hash;
pub mod source_names;
mod source_procedural;
pub mod source_read;
pub mod source_sizes;
#[allow(clippy::indexing_slicing)]
pub mod tessellate;
pub mod texture;
mod texture_read;

pub use error::{LoadError, Place};
pub use scene::{
    Bounds, Camera, Cone, Light, Material, Primitive, Rgb, SampleWishes, Scene, Shape, Sphere,
    Warning,
};
pub use source::{LoadedScene, SceneCatalogue, SceneRef};
pub use source_sizes::SceneSizes;
pub use texture::{Texture, Wrap};
