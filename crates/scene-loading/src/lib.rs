//! Scenes for `rtbench`: one type in f64, loaders for NFF, OBJ, glTF, PLY, STL, PBRT and JSON scene
//! files, and the Standard Procedural Databases generated in code.

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

mod aff;
pub mod animation;
pub mod error;
pub mod fetch;
pub mod gltf;
mod images;
pub mod info;
mod input;
pub mod limits;
mod mesh;
pub mod nff;
pub mod obj;
pub mod pbrt;
pub mod ply;
#[allow(clippy::indexing_slicing)]
mod polygon;
#[allow(clippy::indexing_slicing, clippy::expect_used)]
pub mod procedural;
pub mod progress;
pub mod scene;
pub mod scene_file;
pub mod second_opinion;
pub mod source;
pub mod stl;
#[allow(clippy::indexing_slicing)]
pub mod tessellate;
pub mod tray_racing;
pub mod triangle_soup;
pub mod view_options;
mod words;

pub use error::{FilePlace, LoadError};
pub use scene::{
    Bounds, Camera, Cone, Instance, Light, Material, Primitive, Rgb, SampleWishes, Scene, Shape,
    Sphere, Texture, Warning, Wrap,
};
pub use scene_file::set as scene_set;
pub use source::{LoadedScene, SceneCatalogue, SceneRef, SceneSizes};
pub use source::{hash as source_hash, names as source_names};
pub use view_options::ViewOptions;
