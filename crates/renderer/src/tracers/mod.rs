//! Tracers turn a scene into rays, cones or beams, and these into an image. One line each in
//! [`TRACERS`].

pub mod beam;
pub mod cone;
mod info;
mod recording;
pub mod whitted;
pub mod work;

pub use info::{DrawnImage, Frame, Refusal, Structures, TracerInfo};
pub use recording::generate_rays;

/// Every tracer: one line each.
pub static TRACERS: &[&TracerInfo] = &[&whitted::INFO, &cone::INFO, &beam::INFO];

/// The tracer of that name.
pub fn find(name: &str) -> Option<&'static TracerInfo> {
    TRACERS.iter().find(|t| t.name == name).copied()
}
