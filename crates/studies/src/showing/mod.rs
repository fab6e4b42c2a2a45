//! Pictures of structures: their cells where a plane cuts them or as boxes, and one ray's way
//! through them.
//!
//! The way: [`view`] says where what is seen, [`sections`] what cells there are, one structure at a
//! time; [`picture`] draws them side by side on one scale. [`ray_path`] puts a ray into it.

pub mod picture;
pub mod ray_path;
pub mod sections;
pub mod view;
