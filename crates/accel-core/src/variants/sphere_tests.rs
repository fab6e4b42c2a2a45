//! Other tests of spheres, to be compared with the rearranged one: the quadratic as in textbooks,
//! and the rearranged one in f64.
//!
//! Source of the naive one: A. Glassner (editor), *An Introduction to Ray Tracing*, 1989, chapter
//! 2. Its discriminant b^2 - a c loses the radius of a sphere that is small and far: E. Haines, J.
//! Guenther, T. Akenine-Moeller, "Precision Improvements for Ray/Sphere Intersection", Ray Tracing
//! Gems, chapter 7, 2019. Deviation: directions of any length.

use crate::geometry::ray::Ray;
use crate::geometry::scalar::{Scalar, Vector};
use crate::primitives::{Sphere, SphereTest};

/// The quadratic formula as it stands.
#[derive(Debug, Clone, Copy)]
pub struct NaiveSphere;

impl<S: Scalar> SphereTest<S> for NaiveSphere {
    #[inline(always)]
    fn intersect(sphere: &Sphere<S>, ray: &Ray<S>, t_max: S) -> Option<S> {
        if sphere.radius <= S::ZERO {
            return None;
        }
        let d = ray.direction;
        let f = ray.origin - sphere.center;
        let (a, b) = (d.dot(d), f.dot(d));
        let c = f.dot(f) - sphere.radius * sphere.radius;
        let discriminant = b * b - a * c;
        if discriminant < S::ZERO {
            return None;
        }
        let root = discriminant.sqrt();
        let roots = [(-b - root) / a, (-b + root) / a];
        roots.into_iter().find(|&t| t >= ray.t_min).filter(|&t| t <= t_max)
    }
}

/// The rearranged test in f64, of the same sphere and ray.
#[derive(Debug, Clone, Copy)]
pub struct SphereInDouble;

impl<S: Scalar> SphereTest<S> for SphereInDouble {
    #[inline(always)]
    fn intersect(sphere: &Sphere<S>, ray: &Ray<S>, t_max: S) -> Option<S> {
        let wide = Sphere { center: sphere.center.to_dvec3(), radius: sphere.radius.to_f64() };
        let t = S::from_f64(wide.intersect(&ray.widened(), t_max.to_f64())?);
        (t <= t_max).then_some(t)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_naive_test_invents_and_loses_hits_of_far_spheres() {
        // HARD_CASES G9: false hits from D = 400 on
        let sphere = Sphere::<f32> { center: glam::Vec3::ZERO, radius: 0.1 };
        let mut wrong = 0;
        for i in 0..200 {
            let d = 400.0 + 50.0 * i as f32;
            for (y, expected) in [(0.095, true), (0.105, false)] {
                let ray = Ray::<f32>::new(glam::vec3(-d, y, 0.0), glam::Vec3::X);
                let hit = |t: Option<f32>| t.is_some() == expected;
                wrong += usize::from(!hit(NaiveSphere::intersect(&sphere, &ray, f32::INFINITY)));
                assert!(hit(SphereInDouble::intersect(&sphere, &ray, f32::INFINITY)), "{d}");
            }
        }
        assert!(wrong > 20, "{wrong}");
    }

    #[test]
    fn both_find_near_and_far_roots() {
        let sphere = Sphere::<f32> { center: glam::Vec3::ZERO, radius: 1.0 };
        let mut ray = Ray::<f32>::new(glam::vec3(0.0, 0.0, -3.0), glam::vec3(0.0, 0.0, 2.0));
        let tests: [fn(&_, &_, _) -> _; 2] = [NaiveSphere::intersect, SphereInDouble::intersect];
        for test in tests {
            ray.t_min = 0.0;
            assert_eq!(test(&sphere, &ray, 9.0), Some(1.0));
            assert_eq!(test(&sphere, &ray, 0.5), None);
            ray.t_min = 1.5;
            assert_eq!(test(&sphere, &ray, 9.0), Some(2.0));
        }
    }
}
