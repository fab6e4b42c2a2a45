//! The plane of a triangle or polygon as a face sees it: how deep it lies where, and which cells
//! it covers wholly.
//!
//! Along a plane 1/z is linear in u and v, so its bounds over a cell are those at two corners.

use std::ops::Range;

use glam::{DVec2, DVec3};

use crate::occluders::light_buffer::margins::Margins;
use crate::primitives::Ball;

/// Planes that the light sees under an angle whose sine is less than this cover nothing: the
/// exact test may then go either way.
const LEAST_SINE: f64 = 0.02;
/// The same for planes that rounding may move by more than this part of their distance.
const LARGEST_SHIFT: f64 = 0.01;

/// A plane seen well enough to be used.
#[derive(Debug, Clone)]
pub(super) struct FacingPlane {
    /// Unit normal, the light on its negative side.
    normal: DVec3,
    /// Distance of the plane from the light.
    distance: f64,
    /// By how much rounding may move it.
    shift: f64,
    /// Unit normals of the planes through the light and the edges, towards the inside, in a store
    /// of all; none when the outline is not convex or not flat.
    pub(super) edges: Range<u32>,
    /// Margin in world units for the inside test.
    margin: f64,
}

/// Smallest and largest dot product of `n` with (u, v, 1) over a rectangle.
#[inline(always)]
fn range(n: DVec3, center: DVec2, half: DVec2) -> (f64, f64) {
    let middle = n.truncate().dot(center) + n.z;
    let reach = n.truncate().abs().dot(half);
    (middle - reach, middle + reach)
}

impl FacingPlane {
    /// The plane of an outline of balls; `None` when it is seen too obliquely, or is no plane.
    pub(super) fn of(balls: &[Ball], margins: &Margins, store: &mut Vec<DVec3>) -> Option<Self> {
        let [first, rest @ ..] = balls else { return None };
        if balls.len() < 3 {
            return None;
        }
        let (mut area, mut longest, mut farthest) = (DVec3::ZERO, 0.0_f64, 0.0_f64);
        for (a, b) in rest.iter().zip(rest.iter().skip(1)) {
            area += (a.center - first.center).cross(b.center - first.center);
        }
        for b in balls {
            longest = longest.max(b.center.distance_squared(first.center));
            farthest = farthest.max(b.center.length());
        }
        let length = area.length();
        let mut normal = area / length;
        let mut distance = normal.dot(first.center);
        if distance < 0.0 {
            (normal, distance) = (-normal, -distance);
        }
        // slivers and grazing planes amplify every rounding
        let shift = first.radius * (1.0 + 4.0 * longest / length * (farthest / distance));
        // also refuses NaN; a distance of -0.0 makes the shift negative
        if !(distance > 0.0 && shift <= distance * 0.25) {
            return None;
        }
        let is_flat = first.radius <= margins.position * 2.0;
        let start = store.len();
        if !(is_flat && push_convex_edges(balls, area.dot(normal) < 0.0, store)) {
            store.truncate(start);
        }
        let edges = start as u32..store.len() as u32;
        Some(Self { normal, distance, shift, edges, margin: margins.position * 4.0 })
    }

    /// A lower bound on the depth of the plane over a rectangle.
    pub(super) fn near(&self, center: DVec2, half: DVec2) -> f64 {
        let (_, hi) = range(self.normal, center, half);
        if hi > 0.0 { (self.distance - self.shift) / hi } else { 0.0 }
    }

    /// When the primitive certainly covers the rectangle: an upper bound on its depth there.
    /// `edges` are its own.
    pub(super) fn covers(&self, edges: &[DVec3], center: DVec2, half: DVec2) -> Option<f64> {
        if edges.is_empty() || self.shift > self.distance * LARGEST_SHIFT {
            return None;
        }
        let (lo, _) = range(self.normal, center, half);
        // |(u, v, 1)| is at most the root of 3
        if lo < LEAST_SINE * 1.75 {
            return None;
        }
        let near = self.near(center, half);
        if near < self.margin * 4.0 {
            return None;
        }
        let inside = self.margin / near;
        let is_inside = |m: &DVec3| range(*m, center, half).0 > inside;
        edges.iter().all(is_inside).then(|| (self.distance + self.shift) / lo + self.margin)
    }
}

/// Stores the planes through the light and the edges of a convex outline; false for any other
/// outline.
fn push_convex_edges(balls: &[Ball], is_turned: bool, store: &mut Vec<DVec3>) -> bool {
    let sign = if is_turned { -1.0 } else { 1.0 };
    balls.iter().zip(balls.iter().cycle().skip(1)).all(|(a, b)| {
        // the product of two long corners would cancel where they are near to each other
        let across = a.center.cross(b.center - a.center) * sign;
        let Some(edge) = across.try_normalize() else { return false };
        store.push(edge);
        balls.iter().all(|c| edge.dot(c.center) >= -c.radius)
    })
}
