//! The axes, one per file.

pub mod box_test;
pub mod cell_insertion;
pub mod chosen_tests;
pub mod cone_and_beam;
pub mod effects;
pub mod gating;
pub mod light_buffer;
pub mod mailbox;
pub mod precision;
pub mod ray_offset;
pub mod refracted_shift;
#[cfg(feature = "compiled-tests")]
mod right_aims;
#[cfg(feature = "compiled-tests")]
pub mod right_answers;
#[cfg(feature = "compiled-tests")]
mod right_work;
pub mod secondary_rays;
pub mod shadow_terminator;
pub mod smallest_offset;
pub mod sphere_test;
pub mod time_segments;
pub mod triangle_aims;
pub mod triangle_test;
pub mod voxel_traversal;
