//! Truncated cones and cylinders without caps, one-sided as NFF has them.
//!
//! The surface is F(p) = |p_perp|^2 - r(z)^2 = 0 with r(z) = r0 + k z along the unit axis. Along a
//! ray F is a quadratic A t^2 + 2 B t + C. A hit from outside is where F falls, F' = 2 (A t + B)
//! < 0, and of the two roots that is always `(-B - sqrt(B^2 - A C)) / A`, whatever the sign of A:
//! so one root answers a one-sided cone. The ray is first moved to the point nearest to the
//! cone's middle, which keeps the digits of far origins.
//! (The quadratic is standard; see e.g. A. Glassner (ed.), An Introduction to Ray Tracing, 1989,
//! chapter 2. The choice of root is ours.)

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
    /// Change of radius per unit along the axis.
    slope: S,
    /// A hit so far beyond an end still counts: rounding must leave no crack where two parts of a
    /// pillar meet.
    rim: S,
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
        let slope =
            if length > 0.0 { (apex_radius.abs() - base_radius.abs()) / length } else { 0.0 };
        let size = base.abs().max_element().max(apex.abs().max_element())
            + base_radius.abs().max(apex_radius.abs());
        Self {
            rim: S::from_f64(S::EPSILON.to_f64() * RIM_ULPS * size),
            base: Vec3::<S>::from_dvec3(base),
            axis: Vec3::<S>::from_dvec3(unit),
            length: S::from_f64(length),
            base_radius: S::from_f64(base_radius.abs()),
            apex_radius: S::from_f64(apex_radius.abs()),
            slope: S::from_f64(slope),
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
        let half = S::from_f64(0.5);
        let middle = self.base + w * (self.length * half);
        let shift = (middle - ray.origin).dot(d) / d.dot(d);
        let m = ray.at(shift) - self.base;
        let (dz, mz) = (d.dot(w), m.dot(w));
        let d_perp = d - w * dz;
        let m_perp = m - w * mz;
        let dr = self.slope * dz;
        let r = self.base_radius + self.slope * mz;
        let a = d_perp.dot(d_perp) - dr * dr;
        let b = m_perp.dot(d_perp) - dr * r;
        let c = m_perp.dot(m_perp) - r * r;
        let discriminant = b * b - a * c;
        if discriminant < S::ZERO {
            return None;
        }
        let root = discriminant.sqrt();
        // the falling root (outside) or the rising one (inside), each in the form that does not
        // cancel
        let t = if self.inside_out {
            if b > S::ZERO { -c / (b + root) } else { (root - b) / a }
        } else if b < S::ZERO {
            c / (root - b)
        } else {
            -(b + root) / a
        };
        let z = mz + dz * t;
        let inside = z >= -self.rim && z <= self.length + self.rim && r + dr * t >= S::ZERO;
        let t = t + shift;
        (inside && t >= ray.t_min && t <= t_max).then_some(t)
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

    /// See [`crate::primitives::PrimSet::hull`]. The square of a hit's distance from the axis is off by a few
    /// ulps of the square of the cone's size, which the balls make up for.
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

#[cfg(test)]
mod tests {
    use super::*;

    fn ray(from: [f64; 3], to: [f64; 3]) -> Ray<f64> {
        Ray::new(DVec3::from(from), DVec3::from(to) - DVec3::from(from))
    }

    #[test]
    fn cylinder_shows_its_outside_only() {
        let c = Cone::<f64>::new(DVec3::ZERO, 1.0, DVec3::Z * 2.0, 1.0);
        assert_eq!(c.intersect(&ray([-3.0, 0.0, 1.0], [-2.0, 0.0, 1.0]), 9.0), Some(2.0));
        assert_eq!(c.intersect(&ray([0.0, 0.0, 1.0], [1.0, 0.0, 1.0]), 9.0), None);
        let inside = Cone::<f64>::new(DVec3::ZERO, -1.0, DVec3::Z * 2.0, -1.0);
        assert_eq!(inside.intersect(&ray([0.0, 0.0, 1.0], [1.0, 0.0, 1.0]), 9.0), Some(1.0));
        assert_eq!(inside.intersect(&ray([-3.0, 0.0, 1.0], [-2.0, 0.0, 1.0]), 9.0), Some(4.0));
        // beyond the ends
        assert_eq!(c.intersect(&ray([-3.0, 0.0, 2.1], [-2.0, 0.0, 2.1]), 9.0), None);
        // parallel to the axis
        assert_eq!(c.intersect(&ray([0.5, 0.0, -1.0], [0.5, 0.0, 1.0]), 9.0), None);
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

    #[test]
    fn no_length_no_hit() {
        let c = Cone::<f32>::new(DVec3::ZERO, 1.0, DVec3::ZERO, 1.0);
        let r = Ray::<f32>::new(glam::vec3(-3.0, 0.0, 0.0), glam::Vec3::X);
        assert_eq!(c.intersect(&r, 9.0), None);
        assert!(c.bounds().is_finite());
    }
}
