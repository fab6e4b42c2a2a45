//! The plane of an outline: its area vector, and whether all corners lie in it.

use glam::{DVec2, DVec3};

/// Corners may lie off the plane of their polygon by this share of its extent.
const FLATNESS: f64 = 1e-4;

/// Areas below this share of the squared extent count as zero.
pub(super) const ZERO_AREA: f64 = 1e-15;

/// The area vector of a polygon (Newell's method): normal to it, as long as its area. `None` for
/// a polygon without area.
pub(crate) fn area_vector(corners: &[DVec3]) -> Option<DVec3> {
    let origin = *corners.first()?;
    let mut sum = DVec3::ZERO;
    let mut extent: f64 = 0.0;
    for pair in corners.windows(2) {
        let [a, b] = pair else { continue };
        let (a, b) = (*a - origin, *b - origin);
        sum += a.cross(b);
        extent = extent.max(b.abs().max_element());
    }
    let area = sum * 0.5;
    (area.length() > ZERO_AREA * extent * extent).then_some(area)
}

/// True when all corners lie in one plane, within [`FLATNESS`] of the polygon's extent.
pub(crate) fn is_flat(corners: &[DVec3], area: DVec3) -> bool {
    let normal = area.normalize_or_zero();
    let center = corners.iter().sum::<DVec3>() / corners.len().max(1) as f64;
    let mut extent: f64 = 0.0;
    let mut off: f64 = 0.0;
    for corner in corners {
        extent = extent.max(corner.distance(center));
        off = off.max((*corner - center).dot(normal).abs());
    }
    off <= FLATNESS * extent
}

/// Positive when the three points turn to the left: twice the triangle's area.
pub(super) fn orientation(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    (b - a).perp_dot(c - a)
}
