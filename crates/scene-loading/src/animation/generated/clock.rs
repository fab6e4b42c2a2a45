//! Frames of generated scenes and their times.

use crate::scene::Scene;

/// Makes frames, in any order.
pub(super) type Frames = Box<dyn FnMut(u32) -> Scene + Send>;

/// Frames per second.
pub(super) const RATE: u32 = 25;

/// When a frame is, in seconds.
pub(super) fn seconds(frame: u32) -> f64 {
    f64::from(frame) / f64::from(RATE)
}
