//! Scenes for `rtbench`: one type in f64, loaders for NFF, OBJ, glTF and JSON scene files, and
//! the Standard Procedural Databases generated in code.

pub mod error;
pub mod gltf;
mod gltf_buffers;
mod gltf_nodes;
pub mod nff;
mod nff_tokens;
pub mod obj;
mod obj_material;
mod obj_polygon;
mod obj_scan;
pub mod scene;
pub mod source_read;

pub use error::{LoadError, Place};
pub use scene::{
    Bounds, Camera, Cone, Light, Material, Primitive, Rgb, Scene, Shape, Sphere, Warning,
};
