//! Truncated cones and cylinders without caps, one-sided as NFF has them.
//!
//! The surface is F(p) = (cos |p_perp|)^2 - (cos r0 + sin z)^2 = 0 along the unit axis, by the
//! cosine and sine of the angle between axis and surface: so a flat cone has no steep slope. Along
//! a ray F is a quadratic A t^2 + 2 B t + C. A hit from outside is where F falls, F' = 2 (A t + B)
//! < 0, and of the two roots that is always `(-B - sqrt(B^2 - A C)) / A`, whatever the sign of A:
//! so one root answers a one-sided cone. (The quadratic is standard; see e.g. A. Glassner (ed.), An
//! Introduction to Ray Tracing, 1989, chapter 2. The choice of root is ours.)
//!
//! The ray is first moved to its point nearest to the axis, which keeps the digits of far origins
//! and of thin cylinders; a ray along the axis no further than to an end. B^2 - A C is computed as
//! `cos^2 (|p_perp A' - d_perp B'|^2 - cos^2 |d_perp x p_perp|^2)`, A' and B' being how the second
//! square changes and begins: differences of what is small near the surface.

use glam::DVec3;

use crate::geometry::aabb::Aabb;
use crate::geometry::ray::Ray;
use crate::geometry::scalar::{Scalar, Vec3, Vector};
use crate::primitives::Ball;

/// The tolerance at the ends, in epsilons of the cone's largest coordinate and radius.
const RIM_ULPS: f64 = 8.0;

/// A truncated cone; a cylinder when both radii are equal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cone<S: Scalar> {
    base: Vec3<S>,
    /// Unit axis from base to apex.
    axis: Vec3<S>,
    length: S,
    base_radius: S,
    apex_radius: S,
    /// Cosine of the angle between axis and surface.
    cosine: S,
    sine: S,
    /// A hit so far beyond an end still counts: rounding must leave no crack where two parts of a
    /// pillar meet.
    rim: S,
    /// Rays whose square of the distance from the axis is larger are a miss.
    reach: S,
    /// The inside is visible instead of the outside.
    inside_out: bool,
}

impl<S: Scalar> Cone<S> {
    /// From the two disc centres and radii, in f64. Two radii <= 0 (not both zero) mean that the
    /// inside is visible. A cone without length is kept and never hit.
    pub fn new(base: glam::DVec3, base_radius: f64, apex: glam::DVec3, apex_radius: f64) -> Self {
        let axis = apex - base;
        let length = axis.length();
        let unit = if length > 0.0 { axis / length } else { glam::DVec3::Z };
        let change = apex_radius.abs() - base_radius.abs();
        let side = length.hypot(change);
        let (cosine, sine) = if length > 0.0 { (length / side, change / side) } else { (1.0, 0.0) };
        let radius = base_radius.abs().max(apex_radius.abs());
        let size = base.abs().max_element().max(apex.abs().max_element()) + radius;
        let rim = S::EPSILON.to_f64() * RIM_ULPS * size;
        Self {
            rim: S::from_f64(rim),
            // twice the square: room for what rounding adds to the radius
            reach: S::from_f64(2.0 * (radius + rim) * (radius + rim)),
            base: Vec3::<S>::from_dvec3(base),
            axis: Vec3::<S>::from_dvec3(unit),
            length: S::from_f64(length),
            base_radius: S::from_f64(base_radius.abs()),
            apex_radius: S::from_f64(apex_radius.abs()),
            cosine: S::from_f64(cosine),
            sine: S::from_f64(sine),
            inside_out: base_radius + apex_radius < 0.0,
        }
    }

    /// The hit in `[ray.t_min, t_max]`, if any.
    #[inline(always)]
    pub fn intersect(&self, ray: &Ray<S>, t_max: S) -> Option<S> {
        if self.length <= S::ZERO {
            return None;
        }
        let d = ray.direction;
        let w = self.axis;
        let m = ray.origin - self.base;
        let (dz, mz) = (d.dot(w), m.dot(w));
        let d_perp = d - w * dz;
        let m_perp = m - w * mz;
        let dd = d_perp.dot(d_perp);
        let md = m_perp.dot(d_perp);
        let nearest = -md / dd;
        let mm = m_perp.dot(m_perp);
        let rounding = (mm + mz * mz) * (S::from_f64(16.0) * S::EPSILON);
        // NaN, along the axis, fails the comparison
        if mm + md * nearest - rounding > self.reach {
            return None;
        }
        let shift = if dz * dz > dd {
            let z = (mz + dz * nearest).greater(S::ZERO).lesser(self.length);
            (z - mz) / dz
        } else {
            nearest
        };
        let t = self.intersect_near(ray.at(shift) - self.base, d_perp, dd, dz)? + shift;
        (t >= ray.t_min && t <= t_max).then_some(t)
    }

    /// The parameter of the hit of a ray that begins at `m` from the base, near the cone; `d_perp`
    /// is its direction across the axis, `dd` the square of that, `dz` its direction along the
    /// axis.
    // compiled once, not into each traversal of each structure: most rays are rejected before
    #[inline(never)]
    fn intersect_near(&self, m: Vec3<S>, d_perp: Vec3<S>, dd: S, dz: S) -> Option<S> {
        let mz = m.dot(self.axis);
        let m_perp = m - self.axis * mz;
        let (mm, md) = (m_perp.dot(m_perp), m_perp.dot(d_perp));
        let square = self.cosine * self.cosine;
        let dr = self.sine * dz;
        let r = self.cosine * self.base_radius + self.sine * mz;
        let between = m_perp * dr - d_perp * r;
        let turned = d_perp.cross(m_perp);
        let discriminant = between.dot(between) - square * turned.dot(turned);
        if discriminant < S::ZERO {
            return None;
        }
        let a = square * dd - dr * dr;
        let b = square * md - dr * r;
        let c = square * mm - r * r;
        let root = self.cosine * discriminant.sqrt();
        // the falling root (outside) or the rising one (inside), each in the form that does not
        // cancel
        let t = if self.inside_out {
            if b > S::ZERO { -c / (b + root) } else { (root - b) / a }
        } else if b < S::ZERO {
            c / (root - b)
        } else {
            -(b + root) / a
        };
        let mut place = Place::of(m_perp + d_perp * t, r + dr * t, t);
        // where a ray runs along the surface a root is noise
        if place.is_off(square, self.rim) {
            place = self.refined(place, [m_perp, d_perp], [r, dr], [a, b])?;
        }
        let Place { from_axis, radius, t } = place;
        let z = mz + dz * t;
        // NaN fails the comparisons
        if !(z >= -self.rim && z <= self.length + self.rim) {
            return None;
        }
        if self.sine.abs() <= self.cosine {
            return (radius >= S::ZERO).then_some(t);
        }
        // the radius of a flat cone by its root: its change along the axis says nothing
        let root = if self.inside_out { -discriminant.sqrt() } else { discriminant.sqrt() };
        let radius = (self.cosine * (r * dd - dr * md) - dr * root) / a;
        (radius >= S::ZERO && self.is_between_radii(from_axis)).then_some(t)
    }

    /// Two of Newton's steps from a root that is not on the cone to one that is, if one is there.
    /// The ray across the axis is `m + d t`, its radius `r + dr t`, and half of the slope of F `a t
    /// + b`.
    #[cold]
    #[inline(never)]
    fn refined(
        &self,
        mut place: Place<S>,
        [m, d]: [Vec3<S>; 2],
        [r, dr]: [S; 2],
        [a, b]: [S; 2],
    ) -> Option<Place<S>> {
        let square = self.cosine * self.cosine;
        for _ in 0..2 {
            let slope = a * place.t + b;
            let t = place.t - place.off(square) / (slope + slope);
            place = Place::of(m + d * t, r + dr * t, t);
        }
        // a ray that passes by has no root; one that grazes has any place that is near enough
        let is_outside = place.off(square) > S::ZERO && place.is_off(square, self.rim);
        (!is_outside && place.t.is_finite()).then_some(place)
    }

    /// Whether a square of a distance from the axis lies between those of the two ends.
    #[inline(always)]
    fn is_between_radii(&self, square: S) -> bool {
        let least = self.base_radius.lesser(self.apex_radius) - self.rim;
        let most = self.base_radius.greater(self.apex_radius) + self.rim;
        square <= most * most && (least <= S::ZERO || square >= least * least)
    }

    /// Smallest and largest dot product of `direction` with a point of the two discs at the ends.
    pub(super) fn extent(&self, direction: DVec3) -> (f64, f64) {
        let axis = self.axis.to_dvec3();
        let across = (direction - axis * direction.dot(axis)).length();
        let [base, apex] = self.discs().map(|(centre, radius)| {
            let (along, reach) = (centre.dot(direction), radius * across);
            (along - reach, along + reach)
        });
        (base.0.min(apex.0), base.1.max(apex.1))
    }

    /// See [`crate::primitives::Primitives::hull`]. The square of a hit's distance from the axis is
    /// off by a few ulps of the square of the cone's size, which the balls make up for.
    pub(super) fn hull(&self, balls: &mut Vec<Ball>) {
        let [base, apex] = self.discs();
        let size = self.length.to_f64() + base.1.max(apex.1);
        let rounding = 16.0 * S::EPSILON.to_f64() * size * size;
        for (center, radius) in [base, apex] {
            balls.push(Ball { center, radius: (radius * radius + rounding).sqrt() });
        }
    }

    /// Largest distance from `from` to a point of the two discs, world units.
    pub(super) fn farthest(&self, from: DVec3) -> f64 {
        let axis = self.axis.to_dvec3();
        let [base, apex] = self.discs().map(|(centre, radius)| {
            let along = (centre - from).dot(axis);
            let across = (centre - from - axis * along).length();
            along.hypot(across + radius)
        });
        base.max(apex)
    }

    /// Centre and radius of the discs at both ends.
    fn discs(&self) -> [(DVec3, f64); 2] {
        let (base, axis) = (self.base.to_dvec3(), self.axis.to_dvec3());
        let apex = base + axis * self.length.to_f64();
        [(base, self.base_radius.to_f64()), (apex, self.apex_radius.to_f64())]
    }

    /// Bounds of the two rim circles, rounded outwards.
    pub fn bounds(&self) -> Aabb<S> {
        let w = self.axis.to_array();
        let (p0, p1) = (self.base.to_array(), (self.base + self.axis * self.length).to_array());
        let (mut lo, mut hi) = ([S::ZERO; 3], [S::ZERO; 3]);
        for k in 0..3 {
            let reach = (S::ONE - w[k] * w[k]).greater(S::ZERO).sqrt();
            let (e0, e1) = (reach * self.base_radius, reach * self.apex_radius);
            // the rounding of the axis, its length and the radii: a few ulps of each
            let scale = p0[k].abs().greater(p1[k].abs()) + self.base_radius + self.apex_radius;
            let margin = (scale + self.length) * (S::EPSILON + S::EPSILON);
            lo[k] = (p0[k] - e0).lesser(p1[k] - e1) - margin;
            hi[k] = (p0[k] + e0).greater(p1[k] + e1) + margin;
        }
        Aabb { min: Vec3::<S>::from_array(lo), max: Vec3::<S>::from_array(hi) }
    }
}

/// A point of a ray.
#[derive(Clone, Copy)]
struct Place<S> {
    /// Square of its distance from the axis.
    from_axis: S,
    /// The cosine times the cone's radius at its height.
    radius: S,
    /// Parameter of the ray at this place.
    t: S,
}

impl<S: Scalar> Place<S> {
    #[inline(always)]
    fn of(across: Vec3<S>, radius: S, t: S) -> Self {
        Self { from_axis: across.dot(across), radius, t }
    }

    /// F there; `square` is that of the cosine.
    #[inline(always)]
    fn off(&self, square: S) -> S {
        square * self.from_axis - self.radius * self.radius
    }

    /// Whether it is farther than `rim` from the cone, outside or inside. NaN is.
    #[inline(always)]
    fn is_off(&self, square: S, rim: S) -> bool {
        let near = rim * (self.radius.abs() + self.radius.abs() + rim);
        let is_near = self.off(square).abs() <= near;
        !is_near
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::structures::test_scenes::Random;

    fn ray(from: [f64; 3], to: [f64; 3]) -> Ray<f64> {
        Ray::new(DVec3::from(from), DVec3::from(to) - DVec3::from(from))
    }

    #[test]
    fn cylinder_shows_its_outside_only() {
        let hit = |radius: f64, from: [f64; 3], way: DVec3| {
            let c = Cone::<f64>::new(DVec3::ZERO, radius, DVec3::Z * 2.0, radius);
            c.intersect(&Ray::<f64>::new(from.into(), way), 9.0)
        };
        let (before, inside) = ([-3.0, 0.0, 1.0], [0.0, 0.0, 1.0]);
        assert_eq!([before, inside].map(|from| hit(1.0, from, DVec3::X)), [Some(2.0), None]);
        assert_eq!([before, inside].map(|from| hit(-1.0, from, DVec3::X)), [Some(4.0), Some(1.0)]);
        // beyond the ends, and parallel to the axis
        assert_eq!(hit(1.0, [-3.0, 0.0, 2.1], DVec3::X), None);
        assert_eq!(hit(1.0, [0.5, 0.0, -1.0], DVec3::Z * 2.0), None);
    }

    #[test]
    fn a_ray_nearly_along_the_surface_is_met_where_the_surface_is() {
        // the discriminant keeps six of its digits; found by `rtbench verify --cases Q3flat`
        let base = DVec3::new(-4.210944175720215, 10.825653076171875, -1.0465178489685059);
        let c = Cone::<f64>::new(base, 5.0, base + DVec3::X * 5.7116605043411255, 10.0);
        let origin = DVec3::new(12.109362602233887, 28.300819396972656, -9.229122161865234);
        let direction = DVec3::new(-16.3203067779541, -12.88363115184669, 6.203259776880396);
        let t = c.intersect(&Ray::new(origin, direction), 9.0).unwrap();
        // by arithmetic of 50 digits
        assert!((t - 0.9992899817383979).abs() < 1e-8, "{t}");
    }

    #[test]
    fn cone_from_below_its_apex_plane_and_through_the_apex() {
        let c = Cone::<f64>::new(DVec3::ZERO, 1.0, DVec3::Z, 0.0);
        // straight down onto the slope: outside above it
        let t = c.intersect(&ray([0.5, 0.0, 2.0], [0.5, 0.0, 1.0]), 9.0).unwrap();
        assert!((t - 1.5).abs() < 1e-12, "{t}");
        // straight up from within meets the inside: not visible
        assert_eq!(c.intersect(&ray([0.5, 0.0, -1.0], [0.5, 0.0, 0.0]), 9.0), None);
        // the mirror cone beyond the apex is no part of it
        assert_eq!(c.intersect(&ray([-3.0, 0.0, 1.5], [-2.0, 0.0, 1.5]), 9.0), None);
    }

    #[test]
    fn f32_agrees_with_f64_from_afar() {
        let (p, q) = (DVec3::new(0.3, -0.2, 0.1), DVec3::new(0.5, 0.4, 1.1));
        let (c64, c32) = (Cone::<f64>::new(p, 0.3, q, 0.1), Cone::<f32>::new(p, 0.3, q, 0.1));
        for far in [10.0, 1e3, 1e5] {
            let r = ray([far, 0.1, 0.5], [0.4, 0.1, 0.6]);
            let r32 = Ray::<f32>::new(r.origin.as_vec3(), r.direction.as_vec3());
            let (a, b) = (c64.intersect(&r, 9.0).unwrap(), c32.intersect(&r32, 9.0).unwrap());
            assert!((a - f64::from(b)).abs() < 1e-6, "{far}: {a} {b}");
        }
    }

    /// The distance of a point from the axis less the radius there, and how far beyond an end it
    /// is.
    fn off(base: DVec3, apex: DVec3, radii: [f64; 2], p: DVec3) -> (f64, f64) {
        let axis = apex - base;
        let z = (p - base).dot(axis) / axis.length_squared();
        let from_axis = (p - base - axis * z).length();
        let normal = axis.length() / axis.length().hypot(radii[1] - radii[0]);
        let off = (from_axis - radii[0] - (radii[1] - radii[0]) * z) * normal;
        (off, (z - 1.0).max(-z) * axis.length())
    }

    /// The test as it was: the ray begins at its point nearest to the middle.
    fn from_the_middle<S: Scalar>(c: &Cone<S>, ray: &Ray<S>) -> Option<S> {
        let (d, w) = (ray.direction, c.axis);
        let middle = c.base + w * (c.length * S::from_f64(0.5));
        let shift = (middle - ray.origin).dot(d) / d.dot(d);
        let m = ray.at(shift) - c.base;
        let (dz, mz) = (d.dot(w), m.dot(w));
        let (d_perp, m_perp) = (d - w * dz, m - w * mz);
        let slope = c.sine / c.cosine;
        let (dr, r) = (slope * dz, c.base_radius + slope * mz);
        let a = d_perp.dot(d_perp) - dr * dr;
        let b = m_perp.dot(d_perp) - dr * r;
        let e = m_perp.dot(m_perp) - r * r;
        let discriminant = b * b - a * e;
        if discriminant < S::ZERO {
            return None;
        }
        let root = discriminant.sqrt();
        let t = if b < S::ZERO { e / (root - b) } else { -(b + root) / a };
        let z = mz + dz * t;
        let is_on = z >= -c.rim && z <= c.length + c.rim && r + dr * t >= S::ZERO;
        is_on.then_some(t + shift)
    }

    /// Of rays at a cone: those missed that pass well within it, and those hit where it is not, by
    /// the test and as it was.
    fn wrong<S: Scalar>(radii: [f64; 2], length: f64) -> [usize; 2] {
        let mut random = Random(17);
        let mut counts = [0; 2];
        for _ in 0..3000 {
            let mut point = || random.point([2.0; 3]) - DVec3::ONE;
            let base = Vec3::<S>::from_dvec3(point() * 3.0).to_dvec3();
            let apex = base + (point() + DVec3::splat(1e-3)).normalize() * length;
            let cone = Cone::<S>::new(base, radii[0], apex, radii[1]);
            let [base, apex] = cone.discs().map(|(center, _)| center);
            let axis = (apex - base).normalize();
            let at = random.unit() * 0.98 + 0.01;
            let radius = radii[0] + (radii[1] - radii[0]) * at;
            let (x, y) = axis.any_orthonormal_pair();
            let (sin, cos) = (random.unit() * std::f64::consts::TAU).sin_cos();
            let out = (x * cos + y * sin) * radius;
            let flat = (radii[1] - radii[0]) / length;
            let normal = (out.normalize() - axis * flat).normalize();
            // to a point of the surface, not too flatly, from outside
            let target = base.lerp(apex, at) + out;
            let side = (random.point([2.0; 3]) - DVec3::ONE) * 0.45;
            let way = (normal + side).normalize() * (1.0 + length * random.unit());
            let origin = Vec3::<S>::from_dvec3(target + way);
            let ray = Ray::<S>::new(origin, Vec3::<S>::from_dvec3(target) - origin);
            let size = target.abs().max_element() + way.length() + length + radii[0].max(radii[1]);
            let tolerance = 24.0 * S::EPSILON.to_f64() * size;
            let is_wrong = |t: Option<S>| {
                let Some(t) = t else { return true };
                let p = ray.origin.to_dvec3() + ray.direction.to_dvec3() * t.to_f64();
                let (off, beyond) = off(base, apex, radii, p);
                off.abs() > tolerance || beyond > tolerance || (p - target).length() > 0.1 * size
            };
            counts[0] += usize::from(is_wrong(cone.intersect(&ray, S::INFINITY)));
            counts[1] += usize::from(is_wrong(from_the_middle(&cone, &ray)));
        }
        counts
    }

    #[test]
    fn slender_and_flat_cones_are_hit_where_they_are() {
        let shapes = [
            ([0.5, 0.5], 50.0),
            ([0.01, 0.01], 10.0),
            ([0.01, 0.01], 100.0),
            ([0.02, 0.005], 100.0),
            ([0.01, 0.01], 1000.0),
            ([1.0, 0.2], 0.01),
            ([1.0, 0.2], 1e-5),
            ([0.3, 1.0], 1e-5),
            ([1.0, 0.5], 1e-9),
            ([1.0, 1.0], 1e-3),
        ];
        let mut before = 0;
        for (radii, length) in shapes {
            let [single, double] = [wrong::<f32>(radii, length), wrong::<f64>(radii, length)];
            assert_eq!([single[0], double[0]], [0; 2], "{radii:?} {length}");
            before += single[1] + double[1];
        }
        assert!(before > 500, "planted: {before}");
    }

    /// How far hits of any rays lie outside of their cone's bounds, in epsilons of the largest
    /// coordinate; among them rays along the surface, across it, along the axis and nearly so.
    fn most_outside<S: Scalar>(test: impl Fn(&Cone<S>, &Ray<S>) -> Option<S>) -> f64 {
        let mut random = Random(23);
        let (mut hits, mut most) = (0, 0.0f64);
        for i in 0..30_000 {
            let mut signed = || random.point([2.0; 3]) - DVec3::ONE;
            let length = [1e-9, 1e-5, 1e-3, 0.1, 1.0, 10.0, 100.0][i % 7];
            let axis = (signed() + DVec3::splat(1e-3)).normalize();
            let base = signed() * [0.0, 1.0, 10.0][i % 3];
            let [r0, r1] = [signed().x.abs(), signed().x.abs()].map(|r| r * [0.01, 1.0][i % 2]);
            let sign = if i % 5 == 0 { -1.0 } else { 1.0 };
            let cone = Cone::<S>::new(base, r0 * sign, base + axis * length, r1 * sign);
            let bounds = cone.bounds();
            let (lo, hi, size) =
                (bounds.min.to_dvec3(), bounds.max.to_dvec3(), bounds.magnitude().to_f64());
            let off = signed() * [0.0, 1e-7, 1e-4, 1e-2][i / 7 % 4];
            let (x, y) = axis.any_orthonormal_pair();
            let [turn, at] = [random.unit() * std::f64::consts::TAU, random.unit()];
            let (out, around) = (x * turn.cos() + y * turn.sin(), y * turn.cos() - x * turn.sin());
            let along = (axis * length + out * (r1 - r0)).normalize();
            let target = base + axis * (length * at) + out * (r0 + (r1 - r0) * at);
            let way = [along, along + around * 0.3, axis, around, out][i % 5] + off;
            let origin = target - way * (1.0 + length).min(size);
            let ray = Ray::from_dvec3(origin, way);
            if let Some(t) = test(&cone, &ray) {
                let p = ray.origin.to_dvec3() + ray.direction.to_dvec3() * t.to_f64();
                most = most.max((lo - p).max(p - hi).max_element() / size / S::EPSILON.to_f64());
                hits += 1;
            }
        }
        assert!(hits > 5000, "{hits}");
        most
    }

    #[test]
    fn hits_lie_within_bounds() {
        let ours = most_outside::<f32>(|cone, ray| cone.intersect(ray, f32::INFINITY));
        let wide = most_outside::<f64>(|cone, ray| cone.intersect(ray, f64::INFINITY));
        assert!(ours < 20.0 && wide < 20.0, "{ours} {wide}");
        let planted = most_outside::<f32>(from_the_middle);
        assert!(planted > 1000.0, "{planted}");
    }

    #[test]
    fn cones_without_length_are_never_hit() {
        let c = Cone::<f32>::new(DVec3::ZERO, 1.0, DVec3::ZERO, 1.0);
        let r = Ray::<f32>::new(glam::vec3(-3.0, 0.0, 0.0), glam::Vec3::X);
        assert_eq!(c.intersect(&r, 9.0), None);
        assert!(c.bounds().is_finite());
    }
}
