//! Bounding spheres.
//!
//! Paper: T. Whitted, "An Improved Illumination Model for Shaded Display", CACM 23(6), 1980.
//! Deviations: the centre is that of the box around the primitives, the radius the distance to
//! their farthest point, so the sphere is near the smallest one but seldom the smallest; all in
//! f64, where squares of f32 coordinates of any size have room and rounding is of no account.

use glam::DVec3;

use crate::geometry::aabb::Aabb;
use crate::geometry::ray::Ray;
use crate::geometry::scalar::{Scalar, Vector};
use crate::historical::bounds_rule::BoundsOf;
use crate::structures::bounding_volumes::volume::{Volume, box_around};

/// A sphere with its inside, world units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Ball {
    centre: DVec3,
    radius: f64,
}

/// By how much a radius grows, in paddings of a box: the distance of a centre from a ray is off by
/// more than a coordinate is, as three coordinates go into it.
const PADDINGS: f64 = 4.0;

/// A ray with a direction of unit length.
pub(super) struct UnitRay {
    origin: DVec3,
    unit: DVec3,
    /// Length of the ray's direction as a product: the largest component, and the rest. Their
    /// product, or the square of the first, may overflow.
    scale: [f64; 2],
}

impl<S: Scalar> Volume<S> for Ball {
    type RaySetup = UnitRay;

    fn around(ids: &[u32], boxes: &BoundsOf<S>) -> Self {
        let b = box_around(ids, boxes);
        let centre = b.min.to_dvec3() * 0.5 + b.max.to_dvec3() * 0.5;
        let reach = ids.iter().map(|&id| boxes.prims().farthest(id, centre)).fold(0.0, f64::max);
        Self { centre, radius: reach + boxes.padding().to_f64() * PADDINGS }
    }

    #[inline(always)]
    fn setup(ray: &Ray<S>) -> UnitRay {
        let direction = ray.direction.to_dvec3();
        let largest = direction.abs().max_element();
        let scaled = direction / largest;
        let length = scaled.length();
        UnitRay { origin: ray.origin.to_dvec3(), unit: scaled / length, scale: [length, largest] }
    }

    #[inline(always)]
    fn entry(&self, ray: &UnitRay, t_min: S, t_max: S) -> Option<S> {
        let to_centre = self.centre - ray.origin;
        let along = to_centre.dot(ray.unit);
        let apart = (to_centre - ray.unit * along).length_squared();
        let radius = self.radius * self.radius;
        // squares that overflow make NaN of what follows, which constrains nothing
        if apart > radius {
            return None;
        }
        let half = (radius - apart).sqrt();
        let parameter = |distance: f64| S::from_f64(distance / ray.scale[0] / ray.scale[1]);
        let t_in = parameter(along - half).greater(t_min);
        let t_out = parameter(along + half).lesser(t_max);
        (t_in <= t_out && t_in < S::INFINITY).then_some(t_in)
    }

    fn bounds(&self) -> Aabb<f64> {
        Aabb { min: self.centre, max: self.centre }.expanded(self.radius)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn entry(ball: Ball, o: [f64; 3], d: [f64; 3]) -> Option<f64> {
        let ray = Ray::<f64>::new(o.into(), d.into());
        ball.entry(&<Ball as Volume<f64>>::setup(&ray), ray.t_min, ray.t_max)
    }

    #[test]
    fn from_outside_inside_and_beside() {
        let ball = Ball { centre: DVec3::ZERO, radius: 1.0 };
        assert_eq!(entry(ball, [-3.0, 0.0, 0.0], [2.0, 0.0, 0.0]), Some(1.0));
        assert_eq!(entry(ball, [-3.0, 1.0, 0.0], [2.0, 0.0, 0.0]), Some(1.5));
        assert_eq!(entry(ball, [-3.0, 1.001, 0.0], [2.0, 0.0, 0.0]), None);
        assert_eq!(entry(ball, [0.5, 0.0, 0.0], [2.0, 0.0, 0.0]), Some(0.0));
        assert_eq!(entry(ball, [3.0, 0.0, 0.0], [2.0, 0.0, 0.0]), None);
    }

    #[test]
    fn directions_and_spheres_of_any_size_are_met() {
        for size in [1e-300, 1e-200, 1.0, 1e150, 1e300] {
            let ball = Ball { centre: DVec3::ZERO, radius: size };
            assert!(entry(ball, [-3.0 * size, 0.1 * size, 0.0], [1.0, 0.0, 0.0]).is_some());
        }
        let ball = Ball { centre: DVec3::ZERO, radius: 1.0 };
        for length in [1e-300, 1.0, 1e300] {
            let t = entry(ball, [-3.0, 0.0, 0.0], [length, 0.0, 0.0]);
            assert!(t.is_some_and(|t| (t * length - 2.0).abs() < 1e-12), "{t:?}");
        }
    }
}
