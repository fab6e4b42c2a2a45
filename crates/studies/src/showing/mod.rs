//! Pictures of structures: their cells where a plane cuts them or as boxes, and one ray's way
//! through them.
//!
//! The way: [`mod@plane`] or [`mod@projection`] says where what is seen, [`mod@sections`] what
//! cells there are, one structure at a time; [`picture()`] draws them side by side on one scale.
//! [`mod@way`] puts a ray into it.

pub mod outline;
pub mod picture;
pub mod plane;
pub mod projection;
pub mod ray_path;
pub mod sections;

pub use picture::{DrawnStructure, SectionKind, picture};
pub use plane::{Plane, scene_box};
pub use projection::Projection;
pub use ray_path::{PathThrough, focus, path_through};
pub use sections::{bodies, sections};
