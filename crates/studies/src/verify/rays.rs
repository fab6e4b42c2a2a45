//! Rays of cases.

use accel_core::{Ray, Scalar, Vec3, Vector};
use glam::DVec3;

/// A ray with the interval [0, infinity], rounded to `S`.
pub fn ray<S: Scalar>(origin: DVec3, direction: DVec3) -> Ray<S> {
    Ray::new(Vec3::<S>::from_dvec3(origin), Vec3::<S>::from_dvec3(direction))
}
