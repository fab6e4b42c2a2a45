//! Rays from far away, brought near before anything else looks at them.
//!
//! A ray that starts a thousand scene sizes away has lost the digits that tell cells apart, and
//! every structure would lose them in a way of its own. So its origin is first moved along the ray
//! to just before the scene, once, for all structures and the brute-force oracle alike; a ray that
//! passes the scene at a distance, or leaves it, is a miss at once. (Our own remedy; the loss is
//! case R6 of the hard cases.)

use crate::ray::Ray;
use crate::scalar::{Scalar, Vector};

/// Where a query should start.
#[derive(Debug, Clone, Copy)]
pub enum Place<S: Scalar> {
    /// Where the ray starts.
    Near,
    /// On this ray, whose parameters are smaller by the amount given.
    Moved(Ray<S>, S),
    /// It cannot hit anything, or is no ray at all.
    Nowhere,
}

/// Origins within this many magnitudes of the scene on every axis are near.
const NEAR: f64 = 8.0;

/// The largest coordinate of a near origin, for a scene whose largest coordinate is `magnitude`.
pub fn reach<S: Scalar>(magnitude: S) -> S {
    magnitude * S::from_f64(NEAR)
}

/// Judges a ray.
#[inline(always)]
pub fn place<S: Scalar>(ray: &Ray<S>, reach: S) -> Place<S> {
    if !ray.is_traceable() {
        return Place::Nowhere;
    }
    let [x, y, z] = ray.origin.to_array();
    if x.abs().greater(y.abs()).greater(z.abs()) <= reach { Place::Near } else { moved(ray, reach) }
}

#[cold]
#[inline(never)]
fn moved<S: Scalar>(ray: &Ray<S>, reach: S) -> Place<S> {
    // in f64: far origins overflow the squares of f32
    let (o, d) = (ray.origin.to_dvec3(), ray.direction.to_dvec3());
    let length = d.length();
    let unit = d / length;
    if !unit.is_finite() || unit.length_squared() < 0.5 {
        return Place::Near;
    }
    let along = -o.dot(unit);
    let passing = (o + unit * along).length();
    // the scene lies in a ball of sqrt(3) magnitudes; 2 leaves room for rounding
    let radius = reach.to_f64() * (2.0 / NEAR);
    let slack = along.abs() * S::EPSILON.to_f64() * 4.0;
    if along <= 0.0 || passing > radius + slack {
        return Place::Nowhere;
    }
    let by = S::from_f64((along - 1.5 * radius) / length);
    let near = Ray {
        origin: crate::Vec3::<S>::from_dvec3(o + d * by.to_f64()),
        direction: ray.direction,
        t_min: ray.t_min - by,
        t_max: ray.t_max - by,
        time: ray.time,
    };
    if near.t_min <= near.t_max { Place::Moved(near, by) } else { Place::Nowhere }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ray(o: [f32; 3], d: [f32; 3]) -> Ray<f32> {
        Ray::new(o.into(), d.into())
    }

    #[test]
    fn near_far_and_lost() {
        let reach = reach(1.0f32);
        assert!(matches!(place(&ray([7.0, 0.0, 0.0], [-1.0, 0.0, 0.0]), reach), Place::Near));
        let Place::Moved(near, by) = place(&ray([-1e6, 0.5, 0.0], [2.0, 0.0, 0.0]), reach) else {
            panic!("not moved")
        };
        assert!((near.origin.x + 3.0).abs() < 0.1 && near.origin.y == 0.5);
        assert!((by - 5e5).abs() < 2.0 && near.t_min < 0.0);
        for lost in [
            ray([-1e6, 0.0, 0.0], [-1.0, 0.0, 0.0]),
            ray([-1e6, 100.0, 0.0], [1.0, 0.0, 0.0]),
            ray([0.0, 0.0, 0.0], [0.0, 0.0, 0.0]),
            ray([f32::NAN, 0.0, 0.0], [1.0, 0.0, 0.0]),
        ] {
            assert!(matches!(place(&lost, reach), Place::Nowhere), "{lost:?}");
        }
        // extreme but finite numbers neither overflow nor hang
        for x in [1e30f32, 3e38] {
            assert!(!matches!(place(&ray([-x, 0.0, 0.0], [x, 0.0, 0.0]), reach), Place::Near));
        }
    }
}
