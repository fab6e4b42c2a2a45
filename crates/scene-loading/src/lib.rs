//! Scenes for `rtbench`: one type in f64, loaders for NFF, OBJ, glTF and JSON scene files, and
//! the Standard Procedural Databases generated in code.

pub mod obj_export;
pub mod procedural;
pub mod scene;
pub mod tessellate;

pub use scene::{
    Bounds, Camera, Cone, Light, Material, Primitive, Rgb, Scene, Shape, Sphere, Warning,
};
