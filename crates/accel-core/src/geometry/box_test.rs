//! Tests of boxes for comparison: what a test without a margin loses, what margins cost.
//!
//! Paper: T. Ize, "Robust BVH Ray Traversal", JCGT 2(2), 2013: the slab test in floating point
//! loses boxes whose faces and edges a ray just meets; an exit that is two ulps later does not.
//!
//! Deviations: a box here is the tight one of the primitives, as in the paper. Elsewhere boxes are
//! padded by far more (`bounds_rule.rs`), since points of primitives are rounded as well.

use crate::geometry::aabb::Aabb;
use crate::geometry::ray::Ray;
use crate::geometry::scalar::{Scalar, Vector};

/// A test of boxes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BoxTest {
    /// The slab test as it stands.
    Plain,
    /// The exit is two ulps later.
    Padded,
    /// Like `Padded`, computed in f64.
    Double,
}

impl BoxTest {
    /// The first parameter in `[t_min, t_max]` at which the ray is within the box.
    #[inline(always)]
    pub fn entry<S: Scalar>(self, b: &Aabb<S>, ray: &Ray<S>, t_min: S, t_max: S) -> Option<S> {
        match self {
            Self::Plain => b.clip_by(S::ONE, ray.origin, ray.direction, t_min, t_max),
            Self::Padded => b.clip(ray.origin, ray.direction, t_min, t_max),
            Self::Double => {
                let (o, d) = (ray.origin.to_dvec3(), ray.direction.to_dvec3());
                let clipped = b.in_double().clip(o, d, t_min.to_f64(), t_max.to_f64());
                clipped.map(|(t_in, t_out)| (S::from_f64(t_in), S::from_f64(t_out)))
            }
        }
        .map(|(t_in, _)| t_in)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_plain_test_loses_a_corner_that_the_others_find() {
        let b = Aabb::<f32> { min: glam::vec3(0.1, 0.2, 0.3), max: glam::vec3(1.1, 1.7, 1.9) };
        let mut lost = [0; 3];
        for i in 0..2000 {
            let from = glam::vec3(3.0 + 0.013 * i as f32, -2.0 - 0.007 * i as f32, 5.0);
            // exact: the target is a corner, and the difference has few digits more
            let ray = Ray::<f32>::new(from, b.max - from);
            for (lost, test) in
                lost.iter_mut().zip([BoxTest::Plain, BoxTest::Padded, BoxTest::Double])
            {
                *lost += usize::from(test.entry(&b, &ray, 0.0, 9.0).is_none());
            }
        }
        assert!(lost[0] > 100 && lost[0] > 2 * lost[1], "{lost:?}");
    }

    #[test]
    fn box_tests_agree_away_from_borders() {
        let b = Aabb::<f64> { min: glam::DVec3::ZERO, max: glam::DVec3::ONE };
        for test in [BoxTest::Plain, BoxTest::Padded, BoxTest::Double] {
            let at = |y: f64| {
                let ray = Ray::<f64>::new(glam::dvec3(-1.0, y, 0.5), glam::DVec3::X);
                test.entry(&b, &ray, 0.0, 9.0)
            };
            assert_eq!((at(0.5), at(1.5)), (Some(1.0), None));
        }
    }
}
