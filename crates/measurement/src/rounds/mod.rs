//! Timing: rounds in seeded random order over the rows of a scene.

pub mod error;
pub mod interleaved;
pub mod joined;
pub mod laps;
#[allow(clippy::indexing_slicing)]
pub mod measure;
pub mod row_log;
pub mod scene_run;
pub mod schedule;
pub mod scope;
pub mod stand_in;
pub mod trial;
