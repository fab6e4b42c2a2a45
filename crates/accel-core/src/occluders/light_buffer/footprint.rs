//! Footprint of a primitive on a face of the direction cube: a convex outline that contains its
//! projection, and a lower bound of its depth.
//!
//! Instead of clipping and projecting polygons, the outline is the intersection of half-planes,
//! each found from the angles under which the light sees the balls whose hull holds the primitive.
//! That needs no case for primitives that pass beside or behind the light, or hold it.

use std::f64::consts::{FRAC_PI_2, PI};
use std::ops::Range;

use glam::{DVec2, DVec3, dvec2};

use crate::occluders::light_buffer::facing::FacingPlane;
use crate::occluders::light_buffer::margins::Margins;
use crate::primitives::Ball;

/// Outlines with more vertices than this get bounds on the diagonals instead of their edges.
const MOST_EDGES: usize = 8;

/// The part of a face within `normal . (u, v) <= limit`.
#[derive(Debug, Clone, Copy)]
pub(super) struct HalfPlane {
    pub(super) normal: DVec2,
    pub(super) limit: f64,
}

/// Footprint of a primitive on a face.
#[derive(Debug, Clone)]
pub(super) struct Footprint {
    pub(super) id: u32,
    /// Its lower and upper bounds on the face.
    pub(super) low: DVec2,
    pub(super) high: DVec2,
    /// Its other half-planes, in a store of all.
    pub(super) sides: Range<u32>,
    /// A lower bound on the depth at which it is met.
    pub(super) near: f64,
    /// The plane of a triangle or polygon that the light sees well.
    pub(super) plane: Option<FacingPlane>,
}

/// A body as the light sees it: balls in the frame of a face, the light at the origin.
#[derive(Debug, Default)]
pub(super) struct ProjectedBody {
    /// Their hull holds the primitive; margins are in the radii.
    pub(super) balls: Vec<Ball>,
    /// The balls are the vertices of an outline, in order.
    pub(super) is_outline: bool,
}

impl ProjectedBody {
    /// Nothing of the body is within the pyramid of the face.
    fn is_out_of_pyramid(&self) -> bool {
        let beyond = |normal: DVec3, length: f64| {
            self.balls.iter().all(|b| b.center.dot(normal) > b.radius * length)
        };
        let slant = std::f64::consts::SQRT_2;
        beyond(DVec3::NEG_Z, 1.0)
            || [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y]
                .into_iter()
                .any(|n| beyond(n - DVec3::Z, slant))
    }

    /// Bounds on `normal . (u, v)` over the body; infinite where there are none, `None` when
    /// nothing of it is before the light.
    fn bounds(&self, normal: DVec2) -> Option<(f64, f64)> {
        let flat = |b: &Ball| (normal.x * b.center.x + normal.y * b.center.y, b.center.z);
        let (mut lo, mut hi) = (f64::INFINITY, f64::NEG_INFINITY);
        let is_before = self.balls.iter().all(|b| b.center.z > 2.0 * b.radius);
        if is_before && self.is_outline {
            // a point of the ball is seen within radius (1 + |p|) / (z - radius) of its centre
            for b in &self.balls {
                let inverse = 1.0 / b.center.z;
                let at = flat(b).0 * inverse;
                let slant = 1.0 + b.center.truncate().length() * inverse;
                let reach = b.radius * slant / (b.center.z - b.radius);
                lo = lo.min(at - reach);
                hi = hi.max(at + reach);
            }
            return Some((lo, hi));
        }
        if is_before {
            // tangents of a disc, in the plane of the normal and the axis
            for b in &self.balls {
                let ((a, z), r) = (flat(b), b.radius);
                let root = r * (a * a + z * z - r * r).max(0.0).sqrt();
                let inverse = 1.0 / (z * z - r * r);
                lo = lo.min((a * z - root) * inverse);
                hi = hi.max((a * z + root) * inverse);
            }
            return Some((lo, hi));
        }
        for b in &self.balls {
            let (a, z) = flat(b);
            let distance = a.hypot(z);
            if distance <= b.radius * (1.0 + 1e-9) {
                return Some((f64::NEG_INFINITY, f64::INFINITY));
            }
            let (middle, half) = (a.atan2(z), (b.radius / distance).asin());
            lo = lo.min(middle - half);
            hi = hi.max(middle + half);
        }
        if hi - lo >= PI * (1.0 - 1e-9) {
            return Some((f64::NEG_INFINITY, f64::INFINITY));
        }
        if lo >= FRAC_PI_2 || hi <= -FRAC_PI_2 {
            return None;
        }
        let tangent =
            |angle: f64, none: f64| if angle.abs() < FRAC_PI_2 { angle.tan() } else { none };
        Some((tangent(lo, f64::NEG_INFINITY), tangent(hi, f64::INFINITY)))
    }

    /// Calls `each` with the normals of the half-planes that are worth having, and which side of
    /// each is.
    fn each_normal(&self, each: &mut dyn FnMut(DVec2)) {
        let edge = |a: &Ball, b: &Ball| a.center.cross(b.center).truncate().try_normalize();
        let n = self.balls.len();
        if self.is_outline && n <= MOST_EDGES {
            let next = |i: usize| &self.balls[(i + 1) % n];
            let edges = self.balls.iter().enumerate().filter_map(|(i, b)| edge(b, next(i)));
            edges.for_each(each);
        } else if let [a, b] = self.balls.as_slice()
            && let Some(across) = edge(a, b)
        {
            [across, across.perp()].into_iter().for_each(each);
        } else {
            let half = std::f64::consts::FRAC_1_SQRT_2;
            [dvec2(half, half), dvec2(half, -half)].into_iter().for_each(each);
        }
    }

    /// Its footprint, which adds half-planes to `sides`, or `None` when the face does not show it.
    /// `margins` are those for rounding; those of positions are in the balls already.
    pub(super) fn footprint(
        &self,
        id: u32,
        margins: &Margins,
        sides: &mut Vec<HalfPlane>,
    ) -> Option<Footprint> {
        if self.is_out_of_pyramid() {
            return None;
        }
        let pad = margins.direction;
        let border = 1.0 + pad;
        let (u, v) = (self.bounds(DVec2::X)?, self.bounds(DVec2::Y)?);
        let low = dvec2(u.0 - pad, v.0 - pad).max(DVec2::splat(-border));
        let high = dvec2(u.1 + pad, v.1 + pad).min(DVec2::splat(border));
        if low.x > high.x || low.y > high.y {
            return None;
        }
        let first = sides.len() as u32;
        let (center, half) = ((low + high) * 0.5, (high - low) * 0.5);
        self.each_normal(&mut |normal| {
            let Some((lo, hi)) = self.bounds(normal) else { return };
            for (normal, limit) in [(normal, hi), (-normal, -lo)] {
                let limit = limit + 2.0 * pad;
                // only what cuts something off the rectangle
                if limit < normal.dot(center) + normal.abs().dot(half) {
                    sides.push(HalfPlane { normal, limit });
                }
            }
        });
        // on any face its depth is at least its distance on the axis where that is largest
        let (lo, hi) = box_around(self.balls.iter().copied());
        let near = lo.max(-hi).max_element().max(0.0);
        Some(Footprint { id, low, high, sides: first..sides.len() as u32, near, plane: None })
    }
}

/// Lower and upper corner of a box around balls.
pub(super) fn box_around(balls: impl Iterator<Item = Ball>) -> (DVec3, DVec3) {
    balls.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(lo, hi), ball| {
        (lo.min(ball.center - ball.radius), hi.max(ball.center + ball.radius))
    })
}

impl Footprint {
    /// Returns whether its bounds hold the rectangle: what covers that does.
    #[inline(always)]
    pub(super) fn spans(&self, center: DVec2, half: DVec2) -> bool {
        let (low, high) = (center - half, center + half);
        self.low.cmple(low).all() && self.high.cmpge(high).all()
    }

    /// Returns whether it may reach into the rectangle; `own` are its half-planes.
    #[inline(always)]
    pub(super) fn overlaps(&self, own: &[HalfPlane], center: DVec2, half: DVec2) -> bool {
        let (low, high) = (center - half, center + half);
        if self.low.x > high.x || self.high.x < low.x || self.low.y > high.y || self.high.y < low.y
        {
            return false;
        }
        own.iter().all(|s| s.normal.dot(center) - s.normal.abs().dot(half) <= s.limit)
    }
}
