//! Pictures of structures: their cells where a plane cuts them or as boxes, and one ray's way
//! through them.
//!
//! The way: [`mod@view`] says where what is seen, [`mod@sections`] what cells there are, one
//! structure at a time; [`picture()`] draws them side by side on one scale. [`mod@ray_path`] puts a
//! ray into it.

pub mod picture;
pub mod ray_path;
pub mod sections;
pub mod view;

pub use picture::{DrawnStructure, SectionKind, picture};
pub use ray_path::{PathThrough, focus, path_through};
pub use sections::{bodies, sections};
pub use view::{Plane, Projection, scene_box};
