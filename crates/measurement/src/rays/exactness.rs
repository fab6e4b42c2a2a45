//! How far answers must agree.

use accel_core::query::tracer::Foreign;
use accel_core::structure::Batches;
use accel_core::{Hit, Ray, Scalar, Vec3, Vector};

/// What rounding may do to the parameter of a hit, in parts of it and of the distance from the
/// world's origin to that of the ray: 128 epsilons, 1.5e-5 in f32.
pub fn rounding<S: Scalar>() -> f64 {
    128.0 * S::EPSILON.to_f64()
}

/// Required agreement of answers with the expected ones.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Exactness {
    /// To the last bit: the primitive tests are ours.
    Bits,
    /// A library's own test, as the library is shipped: up to rounding of t; which of the
    /// primitives is named that meet there is not asked.
    Library,
    /// A plugin with its own test: up to rounding of t, and the primitive.
    OwnTest,
    /// A plugin that uses our test: to the last bit.
    OurTest,
}

impl Exactness {
    /// Exactness expected of a structure, by its origin and its batch mode.
    pub fn of(foreign: Option<&dyn Foreign>, batches: Batches) -> Self {
        match foreign.map(|foreign| foreign.origin().has_own_test) {
            Some(true) => Self::OwnTest,
            Some(false) => Self::OurTest,
            None if batches == Batches::Library => Self::Library,
            None => Self::Bits,
        }
    }

    /// Returns whether the structure decides by a primitive test that is not ours.
    pub fn has_own_test(self) -> bool {
        matches!(self, Self::Library | Self::OwnTest)
    }
}

/// Returns whether two hits of a ray are more than rounding apart, or only one is a hit.
pub fn is_apart<S: Scalar>(a: &Hit<S>, b: &Hit<S>, ray: &Ray<S>) -> bool {
    if !a.is_hit() || !b.is_hit() {
        return a.is_hit() != b.is_hit();
    }
    let largest = |v: Vec3<S>| v.to_dvec3().abs().max_element();
    let (t, other) = (a.t.to_f64(), b.t.to_f64());
    let scale = other.abs() + largest(ray.origin) / largest(ray.direction);
    let distance = (t - other).abs();
    distance.is_nan() || scale.is_nan() || distance > rounding::<S>() * scale
}
