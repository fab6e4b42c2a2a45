//! In f64, where a ray meets a cone or a polygon: oracles of their own, not the
//! product's arithmetic in another precision.
//!
//! A cone is met where the distance to its surface changes sign along the ray, found by bisection
//! instead of a quadratic; a polygon by counting crossings with exact orientation predicates (crate
//! `robust`).

use accel_core::{Ray, Scalar, Vector};
use glam::{DVec2, DVec3};
use robust::{Coord, orient2d};

use super::round::Expected;

/// A truncated cone or cylinder without caps, seen from outside, in f64.
#[derive(Debug, Clone, Copy)]
pub struct ConeShape {
    /// Centre of the first disc, and its radius.
    pub base: (DVec3, f64),
    /// Of the second.
    pub apex: (DVec3, f64),
}

/// How close, over the size of the shape, a ray may come to a rim, a tangent or an edge for
/// rounding to decide.
const UNCLEAR: f64 = 1e-3;

impl ConeShape {
    /// Height over the base and distance to the surface, negative inside, at parameter `t`.
    fn at(&self, origin: DVec3, direction: DVec3, t: f64) -> (f64, f64) {
        let axis = self.apex.0 - self.base.0;
        let length = axis.length();
        let p = origin + direction * t - self.base.0;
        let height = p.dot(axis) / length;
        let across = (p - axis / length * height).length();
        let radius = self.base.1 + (self.apex.1 - self.base.1) * height / length;
        (height, across - radius)
    }

    /// What is expected of a ray: the first crossing from outside to inside between the discs.
    ///
    /// Outside, the distance to a convex body falls and then rises along a line, so that a
    /// minimum is found by thirds and the crossing before it by halves.
    pub fn expected<S: Scalar>(&self, ray: &Ray<S>) -> Expected {
        let (origin, direction) = (ray.origin.to_dvec3(), ray.direction.to_dvec3());
        let axis = self.apex.0 - self.base.0;
        let length = axis.length();
        if length == 0.0 {
            return Expected::Miss;
        }
        let size = length.max(self.base.1).max(self.apex.1);
        let unclear = UNCLEAR * size;
        let is_tip = |(tip, radius): (DVec3, f64)| {
            let passing = (tip - origin).cross(direction).length() / direction.length();
            radius < unclear && passing < 2.0 * unclear
        };
        if is_tip(self.base) || is_tip(self.apex) {
            return Expected::Anything;
        }
        // the part of the ray between the planes of the discs, a little more on both sides
        let along = direction.dot(axis) / length;
        let height = (origin - self.base.0).dot(axis) / length;
        let reach = 4.0 * (size + (origin - self.base.0).length()) / direction.length();
        let (mut from, mut to) = (0.0_f64, reach);
        if along == 0.0 {
            if height < -unclear || height > length + unclear {
                return Expected::Miss;
            }
        } else {
            let ends = [-unclear, length + unclear].map(|h| (h - height) / along);
            from = from.max(ends[0].min(ends[1]));
            to = to.min(ends[0].max(ends[1]));
        }
        if from >= to {
            return Expected::Miss;
        }
        let distance = |t: f64| self.at(origin, direction, t).1;
        let lowest = by_thirds(from, to, distance);
        match distance(lowest) {
            d if d > unclear => return Expected::Miss,
            d if d > -unclear => return Expected::Anything,
            _ => {}
        }
        if distance(from) < -unclear {
            // within already: surfaces are seen from outside only
            return Expected::Miss;
        }
        if distance(from) < unclear {
            return Expected::Anything;
        }
        let t = by_halves(from, lowest, distance);
        let (height, _) = self.at(origin, direction, t);
        let is_near = |h: f64| (height - h).abs() < 2.0 * unclear;
        if is_near(0.0) || is_near(length) {
            return Expected::Anything;
        }
        // a ray that meets the surface at a slant is late or early by more
        let steep = (distance(t - 1e-4 * reach) - distance(t + 1e-4 * reach)) / (2e-4 * reach);
        Expected::hit_at(t, 1e-4 * size / steep.max(1e-3 * direction.length()))
    }
}

/// Where a function that falls and then rises is least.
fn by_thirds(mut from: f64, mut to: f64, f: impl Fn(f64) -> f64) -> f64 {
    for _ in 0..200 {
        let third = (to - from) / 3.0;
        if f(from + third) < f(to - third) {
            to -= third;
        } else {
            from += third;
        }
    }
    (from + to) / 2.0
}

/// Where a function changes from positive to negative.
fn by_halves(mut from: f64, mut to: f64, f: impl Fn(f64) -> f64) -> f64 {
    for _ in 0..200 {
        let middle = (from + to) / 2.0;
        if f(middle) > 0.0 {
            from = middle;
        } else {
            to = middle;
        }
    }
    to
}

/// Whether a point is within an outline, by the even-odd rule; `None` within `unclear` of an edge.
pub fn encloses(outline: &[DVec2], p: DVec2, unclear: f64) -> Option<bool> {
    let coord = |p: DVec2| Coord { x: p.x, y: p.y };
    let mut is_inside = false;
    for (i, &a) in outline.iter().enumerate() {
        let b = *outline.get(i + 1).or(outline.first())?;
        let part =
            ((p - a).dot(b - a) / (b - a).length_squared().max(f64::MIN_POSITIVE)).clamp(0., 1.);
        if p.distance(a + (b - a) * part) < unclear {
            return None;
        }
        if (a.y > p.y) != (b.y > p.y) {
            let left = orient2d(coord(a), coord(b), coord(p)) > 0.0;
            is_inside ^= left == (b.y > a.y);
        }
    }
    Some(is_inside)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{dvec2, dvec3};

    fn expected(shape: &ConeShape, origin: DVec3, direction: DVec3) -> Expected {
        shape.expected(&Ray::<f64>::new(origin, direction))
    }

    #[test]
    fn a_cone_is_met_where_it_is_met_on_paper() {
        let cone = ConeShape { base: (DVec3::ZERO, 1.0), apex: (DVec3::Z, 0.0) };
        // at half its height the radius is a half
        let Expected::Hit { id: None, t: [low, high] } =
            expected(&cone, dvec3(-2.0, 0.0, 0.5), DVec3::X)
        else {
            panic!("no hit")
        };
        assert!(low < 1.5 && 1.5 < high && high - low < 1e-2, "{low} {high}");
        // parallel to the axis, from above: at (0.25, 0) the surface is 0.75 high
        let Expected::Hit { t: [low, high], .. } =
            expected(&cone, dvec3(0.25, 0.0, 3.0), -DVec3::Z)
        else {
            panic!("no hit")
        };
        assert!(low < 2.25 && 2.25 < high && high - low < 1e-2, "{low} {high}");
        assert_eq!(expected(&cone, dvec3(0.1, 0.0, 0.3), DVec3::X), Expected::Miss);
        assert_eq!(expected(&cone, dvec3(-2.0, 0.0, 1.5), DVec3::X), Expected::Miss);
        assert_eq!(expected(&cone, dvec3(-2.0, 1.2, 0.1), DVec3::X), Expected::Miss);
        assert_eq!(expected(&cone, dvec3(0.0, 0.0, 3.0), -DVec3::Z), Expected::Anything);
        let flat = ConeShape { base: (DVec3::ZERO, 1.0), apex: (DVec3::ZERO, 0.5) };
        assert_eq!(expected(&flat, dvec3(0.7, 0.0, 3.0), -DVec3::Z), Expected::Miss);
    }

    #[test]
    fn an_outline_encloses_what_even_and_odd_say() {
        let arrow = [dvec2(0.0, 0.0), dvec2(2.0, 0.0), dvec2(0.2, 0.2), dvec2(0.0, 2.0)];
        let within = |x, y| encloses(&arrow, dvec2(x, y), 1e-6);
        assert_eq!(within(0.1, 0.1), Some(true));
        assert_eq!(within(0.5, 0.5), Some(false));
        assert_eq!(within(1.0, 0.05), Some(true));
        assert_eq!(within(1.0, 0.0), None);
        assert_eq!(within(-1.0, 0.0), Some(false));
    }
}
