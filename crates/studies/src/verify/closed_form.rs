//! Oracle of rays against cones, in double-double arithmetic.
//!
//! Along a ray, the square of the distance from the axis less that of the radius is a quadratic. It
//! is solved for the cone with its radius a little larger and a little smaller: what rounding may
//! do to a ray lies between.

use accel_core::{Ray, Scalar, Vector};
use glam::DVec3;

use super::round::OracleAnswer;
use exact_geometry::double_double::{DoubleDouble, difference, dot, vector};

/// Epsilons of the distance to the farthest point, or of the largest coordinate, by which the
/// product's rounding may move a ray sideways: half of what structures pad boxes by.
const SHIFT: f64 = 32.0;

/// A truncated cone or cylinder without caps, seen from outside; from inside where its radii are
/// negative.
#[derive(Debug, Clone, Copy, Default)]
pub struct ConeShape {
    /// Centre of the first disc, and its radius.
    pub base: (DVec3, f64),
    pub apex: (DVec3, f64),
}

/// Crossing of the surface of the infinite cone.
#[derive(Debug, Clone, Copy)]
struct Crossing {
    t: f64,
    height: f64,
    /// Radius of the cone there, negative beyond its apex.
    radius: f64,
}

impl ConeShape {
    fn axis(&self) -> DVec3 {
        self.apex.0 - self.base.0
    }

    /// Expected answer for a ray in a scene whose largest coordinate is `magnitude`.
    pub fn expected<S: Scalar>(&self, ray: &Ray<S>, magnitude: f64) -> OracleAnswer {
        let length = self.axis().length();
        if length == 0.0 {
            return OracleAnswer::Miss;
        }
        let (origin, direction) = (ray.origin.to_dvec3(), ray.direction.to_dvec3());
        let far = [self.base, self.apex].map(|(p, r)| p.distance(origin) + r.abs());
        let reach = far[0].max(far[1]).min(9.0 * magnitude).max(magnitude);
        let shift = SHIFT * S::EPSILON.to_f64() * reach;
        let slope = (self.apex.1 - self.base.1) / length;
        // of the radius, for the surface to move so far
        let more = shift * (1.0 + slope * slope).sqrt();
        // near a tip rounding may take one side of it for the other
        let near_tip = 2.0 * more;
        let passes = |(tip, radius): (DVec3, f64)| {
            let away = (tip - origin).cross(direction).length() / direction.length();
            radius.abs() <= near_tip && away <= near_tip + 4.0 * shift
        };
        if passes(self.base) || passes(self.apex) {
            return OracleAnswer::Anything;
        }
        let outer = match self.crossing(origin, direction, more) {
            Some(outer) if outer.radius > near_tip => outer,
            Some(outer) if outer.radius > -near_tip => return OracleAnswer::Anything,
            _ => return OracleAnswer::Miss,
        };
        let inner = match self.crossing(origin, direction, -more) {
            Some(inner) if inner.radius > near_tip => inner,
            _ => return OracleAnswer::Anything,
        };
        let (low, high) = ordered(outer.height, inner.height);
        if high < -shift || low > length + shift {
            return OracleAnswer::Miss;
        }
        if low < shift || high > length - shift {
            return OracleAnswer::Anything;
        }
        let (low, high) = ordered(outer.t, inner.t);
        let slack = shift / direction.length();
        let t = [low - slack, high + slack];
        let [start, end] = [ray.t_min, ray.t_max].map(S::to_f64);
        if start <= t[0] && t[1] <= end {
            OracleAnswer::Hit { id: None, t }
        } else if t[1] < start || end < t[0] {
            OracleAnswer::Miss
        } else {
            OracleAnswer::Anything
        }
    }

    /// Crossing at which the ray's line enters (or leaves, if that side is visible) the infinite
    /// cone with a radius larger by `more`.
    fn crossing(&self, origin: DVec3, direction: DVec3, more: f64) -> Option<Crossing> {
        type D = DoubleDouble;
        let is_inside_out = self.base.1 + self.apex.1 < 0.0;
        let radii = [self.base.1, self.apex.1].map(|r| D::from(r.abs()) + D::from(more));
        let axis = difference(self.apex.0, self.base.0);
        let squared = dot(axis, axis);
        let (d, m) = (vector(direction), difference(origin, self.base.0));
        // heights in lengths of the axis
        let (dh, mh) = (dot(d, axis) / squared, dot(m, axis) / squared);
        let across = |v: [D; 3], h: D| [0, 1, 2].map(|k| v[k] - axis[k] * h);
        let (d, m) = (across(d, dh), across(m, mh));
        let widening = radii[1] - radii[0];
        let (dr, r) = (widening * dh, radii[0] + widening * mh);
        let (a, b, c) = (dot(d, d) - dr * dr, dot(m, d) - dr * r, dot(m, m) - r * r);
        let discriminant = b * b - a * c;
        if discriminant < D::ZERO {
            return None;
        }
        let root = discriminant.sqrt();
        // where the quadratic falls, or rises
        let root = if is_inside_out { root } else { -root };
        let t = if (b > D::ZERO) == is_inside_out { -c / (b + root) } else { (root - b) / a };
        let height = ((mh + dh * t) * squared.sqrt()).high;
        t.high.is_finite().then_some(Crossing { t: t.high, height, radius: (r + dr * t).high })
    }
}

/// First hit according to the expectations of all primitives, each alone.
pub fn first_of(all: impl Iterator<Item = (u32, OracleAnswer)>) -> OracleAnswer {
    let mut hits = Vec::new();
    for (id, expected) in all {
        match expected {
            OracleAnswer::Hit { t, .. } => hits.push((t, id)),
            OracleAnswer::Miss => {}
            _ => return OracleAnswer::Anything,
        }
    }
    hits.sort_by(|a, b| a.0[0].total_cmp(&b.0[0]));
    let Some(&(first, id)) = hits.first() else { return OracleAnswer::Miss };
    let is_alone = hits.iter().skip(1).all(|(t, _)| t[0] > first[1]);
    let high = hits.iter().map(|(t, _)| t[1]).fold(f64::INFINITY, f64::min);
    OracleAnswer::Hit { id: is_alone.then_some(id), t: [first[0], high] }
}

fn ordered(a: f64, b: f64) -> (f64, f64) {
    (a.min(b), a.max(b))
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::dvec3;

    fn expected(shape: &ConeShape, origin: DVec3, direction: DVec3) -> OracleAnswer {
        shape.expected(&Ray::<f64>::new(origin, direction), 4.0)
    }

    fn is_hit_at(expected: &OracleAnswer, at: f64) -> bool {
        matches!(*expected, OracleAnswer::Hit { t: [low, high], .. }
            if low < at && at < high && high - low < 1e-6)
    }

    #[test]
    fn a_cone_is_met_where_it_is_met_on_paper() {
        let cone = ConeShape { base: (DVec3::ZERO, 1.0), apex: (DVec3::Z, 0.0) };
        // at half its height the radius is a half
        assert!(is_hit_at(&expected(&cone, dvec3(-2.0, 0.0, 0.5), DVec3::X), 1.5));
        // parallel to the axis, from above: at (0.25, 0) the surface is 0.75 high
        assert!(is_hit_at(&expected(&cone, dvec3(0.25, 0.0, 3.0), -DVec3::Z), 2.25));
        assert_eq!(expected(&cone, dvec3(0.1, 0.0, 0.3), DVec3::X), OracleAnswer::Miss);
        assert_eq!(expected(&cone, dvec3(-2.0, 0.0, 1.5), DVec3::X), OracleAnswer::Miss);
        assert_eq!(expected(&cone, dvec3(-2.0, 1.2, 0.1), DVec3::X), OracleAnswer::Miss);
        assert_eq!(expected(&cone, dvec3(0.0, 0.0, 3.0), -DVec3::Z), OracleAnswer::Anything);
        let inside_out = ConeShape { base: (DVec3::ZERO, -1.0), apex: (DVec3::Z, 0.0) };
        assert!(is_hit_at(&expected(&inside_out, dvec3(-2.0, 0.0, 0.5), DVec3::X), 2.5));
        let flat = ConeShape { base: (DVec3::ZERO, 1.0), apex: (DVec3::ZERO, 0.5) };
        assert_eq!(expected(&flat, dvec3(0.7, 0.0, 3.0), -DVec3::Z), OracleAnswer::Miss);
    }

    #[test]
    fn thin_cylinders_are_hit_accurately_in_both_precisions() {
        let wire = ConeShape { base: (DVec3::ZERO, 1e-3), apex: (DVec3::Z * 100.0, 1e-3) };
        for part in [0.0, 0.5, 0.99] {
            let y = 1e-3 * part;
            let ray = Ray::<f64>::new(dvec3(2.0, y, -1.0), dvec3(-2.0, 0.0, 100.0));
            let OracleAnswer::Hit { t: [low, high], .. } = wire.expected(&ray, 100.0) else {
                panic!("{part}")
            };
            let t = (2.0 - (1e-6 - y * y).sqrt()) / 2.0;
            assert!(low < t && t < high && high - low < 1e-9, "{part}: {low} {t} {high}");
        }
        let beside = Ray::<f64>::new(dvec3(2.0, 1.001e-3, -1.0), dvec3(-2.0, 0.0, 100.0));
        assert_eq!(wire.expected(&beside, 100.0), OracleAnswer::Miss);
        // single precision cannot tell
        let beside = Ray::<f32>::new(glam::vec3(2.0, 1.001e-3, -1.0), glam::vec3(-2.0, 0.0, 100.0));
        assert_eq!(wire.expected(&beside, 100.0), OracleAnswer::Anything);
    }

    #[test]
    fn hits_at_the_same_place_have_no_first() {
        let hit = |low, high| OracleAnswer::Hit { id: None, t: [low, high] };
        let first = |all: Vec<OracleAnswer>| first_of((0..).zip(all));
        let named = |id, t| OracleAnswer::Hit { id, t };
        assert_eq!(first(vec![hit(3.0, 4.0), hit(1.0, 2.0)]), named(Some(1), [1.0, 2.0]));
        assert_eq!(first(vec![hit(1.0, 4.0), hit(2.0, 3.0)]), named(None, [1.0, 3.0]));
        assert_eq!(first(vec![OracleAnswer::Miss]), OracleAnswer::Miss);
        assert_eq!(first(vec![hit(1.0, 2.0), OracleAnswer::Anything]), OracleAnswer::Anything);
    }
}
