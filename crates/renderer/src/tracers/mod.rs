//! Tracers turn a scene into rays and an image.

pub mod stages;
pub mod whitted;
