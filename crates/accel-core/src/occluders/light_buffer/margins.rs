//! How far rounding can carry a hit, a direction or a depth from where it should be.
//!
//! Let a shadow ray start at P and end, in its own arithmetic, within `end` of the light L. Each
//! of its hits is within `hit` of a point of the primitive, and so within `hit + end` of the exact
//! segment from P to L. Cells are looked up by the direction from L to P, which subtraction and
//! division round once each. So a cell that lists every primitive of which a point within
//! `position` is seen from L in the cell grown by `direction` misses none.

use crate::geometry::scalar::Scalar;

/// Margins of a build, in f64.
#[derive(Debug, Clone, Copy)]
pub(super) struct Margins {
    /// World units by which primitives grow.
    pub(super) position: f64,
    /// By how much the place of a direction on its face may be off.
    pub(super) direction: f64,
    /// Largest distance on an axis from a ray's end to its light, world units.
    pub(super) end: f64,
    /// A part of a depth that no rounding of it exceeds.
    pub(super) depth: f64,
    /// Products of coordinates and of their last places are numbers: neither too large nor nothing.
    /// Where they are not, the exact test may miss what is there.
    pub(super) can_multiply: bool,
}

/// Ulps (of the largest coordinate of scene and lights) from a hit to its primitive, as for the
/// padded boxes of structures.
const HIT_ULPS: f64 = 64.0;
/// The same from the end of a ray to its light.
const END_ULPS: f64 = 32.0;
/// The same for whatever the build itself rounds, in f64.
const BUILD_ULPS: f64 = 32.0;

impl Margins {
    /// For a scene and lights whose largest coordinate is `magnitude`.
    pub(super) fn new<S: Scalar>(magnitude: f64) -> Self {
        let epsilon = S::EPSILON.to_f64();
        // a scene at the very origin still needs a margin
        let ulp = (epsilon * magnitude).max(1e-30);
        let (large, last) = (S::from_f64(magnitude * 16.0), S::from_f64(ulp));
        let can_multiply =
            (large * large * large).is_finite() && last * last * S::EPSILON > S::ZERO;
        Self {
            position: ulp * (HIT_ULPS + END_ULPS * 2.0 + BUILD_ULPS),
            direction: epsilon * 16.0,
            end: ulp * END_ULPS,
            depth: epsilon * 8.0,
            can_multiply,
        }
    }
}
