//! Which way three points of the plane turn.

use glam::DVec2;

/// Positive when the three points turn to the left: twice the triangle's area.
pub(super) fn orientation(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    (b - a).perp_dot(c - a)
}
