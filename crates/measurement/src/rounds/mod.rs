//! Timing: rounds in seeded random order over the rows of a scene.

pub mod error;
pub mod interleaved;
pub mod joined;
#[allow(clippy::indexing_slicing)]
pub mod measure;
pub mod scene_run;
pub mod scope;
pub mod trial;
