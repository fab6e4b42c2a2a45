//! Spheres, two-sided.
//!
//! The discriminant is rearranged so that small and far spheres keep their digits: E. Haines,
//! J. Guenther, T. Akenine-Moeller, "Precision Improvements for Ray/Sphere Intersection", Ray
//! Tracing Gems, chapter 7, 2019. Deviation: directions of any length. A sphere that is hit is
//! within 18 epsilons of the scene's largest coordinate of the ray (`proofs/sphere.gappa`).

use glam::DVec3;

use crate::geometry::aabb::Aabb;
use crate::geometry::ray::Ray;
use crate::geometry::scalar::{Scalar, Vec3, Vector};
use crate::primitives::Ball;

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sphere<S: Scalar> {
    pub center: Vec3<S>,
    /// Radius, >= 0; a sphere of radius 0 is never hit.
    pub radius: S,
}

/// A way to intersect a ray with a sphere.
pub trait SphereTest<S: Scalar>: Send + Sync + 'static {
    /// The parameter of the hit if it lies in `[ray.t_min, t_max]`.
    fn intersect(sphere: &Sphere<S>, ray: &Ray<S>, t_max: S) -> Option<S>;
}

#[derive(Debug, Clone, Copy)]
pub struct RearrangedSphere;

impl<S: Scalar> SphereTest<S> for RearrangedSphere {
    #[inline(always)]
    fn intersect(sphere: &Sphere<S>, ray: &Ray<S>, t_max: S) -> Option<S> {
        sphere.intersect(ray, t_max)
    }
}

impl<S: Scalar> Sphere<S> {
    /// The near root if it lies in `[ray.t_min, t_max]`, else the far one likewise.
    #[inline(always)]
    pub fn intersect(&self, ray: &Ray<S>, t_max: S) -> Option<S> {
        self.intersect_from(ray.origin, ray, ray.direction.dot(ray.direction), t_max)
    }

    /// The same of the ray as it would be from another origin; `a` is the square of its direction's
    /// length.
    #[inline(always)]
    pub(super) fn intersect_from(
        &self,
        origin: Vec3<S>,
        ray: &Ray<S>,
        a: S,
        t_max: S,
    ) -> Option<S> {
        if self.radius <= S::ZERO {
            return None;
        }
        let d = ray.direction;
        let f = origin - self.center;
        let b = -f.dot(d);
        let r2 = self.radius * self.radius;
        // distance of the centre from the line, as a vector
        let l = f + d * (b / a);
        let discriminant = r2 - l.dot(l);
        if discriminant < S::ZERO {
            return None;
        }
        let c = f.dot(f) - r2;
        let root = (a * discriminant).sqrt();
        let q = if b < S::ZERO { b - root } else { b + root };
        // q == 0: tangent at the origin, both roots are 0
        let (t0, t1) = if q == S::ZERO { (S::ZERO, S::ZERO) } else { (c / q, q / a) };
        let (near, far) = if t0 < t1 { (t0, t1) } else { (t1, t0) };
        [near, far].into_iter().find(|&t| t >= ray.t_min).filter(|&t| t <= t_max)
    }

    /// Smallest and largest dot product of `direction` with a point of the surface.
    pub(super) fn extent(&self, direction: DVec3) -> (f64, f64) {
        let along = self.center.to_dvec3().dot(direction);
        let reach = self.radius.to_f64() * direction.length();
        (along - reach, along + reach)
    }

    pub(super) fn hull(&self, balls: &mut Vec<Ball>) {
        balls.push(Ball { center: self.center.to_dvec3(), radius: self.radius.to_f64() });
    }

    /// Largest distance from `from` to a point of the surface, world units.
    pub(super) fn farthest(&self, from: DVec3) -> f64 {
        self.center.to_dvec3().distance(from) + self.radius.to_f64()
    }

    pub fn bounds(&self) -> Aabb<S> {
        let (c, r) = (self.center.to_array(), self.radius);
        Aabb {
            min: Vec3::<S>::from_array(c.map(|x| outward(x - r, x, r, false))),
            max: Vec3::<S>::from_array(c.map(|x| outward(x + r, x, r, true))),
        }
    }
}

/// `x +- r` moved outwards when the sum was not exact.
fn outward<S: Scalar>(sum: S, x: S, r: S, up: bool) -> S {
    let exact = if up { sum - x == r && sum - r == x } else { x - sum == r && sum + r == x };
    match (exact, up) {
        (true, _) => sum,
        (false, true) => sum.next_up(),
        (false, false) => sum.next_down(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn far_small_sphere_keeps_its_digits() {
        // HARD_CASES G9: the naive f32 quadratic gives false hits from D = 400
        let s = Sphere::<f32> { center: glam::Vec3::ZERO, radius: 0.1 };
        for d in [1e2f32, 1e3, 1e4, 1e5] {
            let hit = Ray::<f32>::new(glam::vec3(-d, 0.095, 0.0), glam::Vec3::X);
            let t = s.intersect(&hit, f32::INFINITY).unwrap();
            assert!((t - (d - 0.031_225)).abs() <= d * 2.0 * f32::EPSILON, "D = {d}: t = {t}");
            let miss = Ray::<f32>::new(glam::vec3(-d, 0.105, 0.0), glam::Vec3::X);
            assert_eq!(s.intersect(&miss, f32::INFINITY), None, "D = {d}");
        }
    }

    #[test]
    fn inside_and_interval() {
        let s = Sphere::<f64> { center: glam::DVec3::ZERO, radius: 1.0 };
        let mut ray = Ray::<f64>::new(glam::DVec3::ZERO, glam::DVec3::new(0.0, 0.0, 2.0));
        assert_eq!(s.intersect(&ray, 9.0), Some(0.5));
        assert_eq!(s.intersect(&ray, 0.4), None);
        ray.origin = glam::DVec3::new(0.0, 0.0, -2.0);
        assert_eq!(s.intersect(&ray, 9.0), Some(0.5));
        ray.t_min = 0.6;
        assert_eq!(s.intersect(&ray, 9.0), Some(1.5));
        ray.t_min = 1.6;
        assert_eq!(s.intersect(&ray, 9.0), None);
    }

    #[test]
    fn point_sphere_is_never_hit() {
        let s = Sphere::<f32> { center: glam::Vec3::ZERO, radius: 0.0 };
        let ray = Ray::<f32>::new(glam::vec3(0.0, 0.0, -1.0), glam::Vec3::Z);
        assert_eq!(s.intersect(&ray, 9.0), None);
    }
}
