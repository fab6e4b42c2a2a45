//! Rays and hits of the interface as ours, and back.

use crate::abi;

impl abi::Hit {
    /// An answer as ours: of a miss nothing but that is read.
    pub(crate) fn as_ours(&self, ray: &accel_core::Ray<f32>) -> accel_core::Hit<f32> {
        match self.id {
            abi::MISS => accel_core::Hit { t: ray.t_max, id: accel_core::MISS },
            id => accel_core::Hit { t: self.t, id },
        }
    }
}

impl From<&accel_core::Ray<f32>> for abi::Ray {
    fn from(ray: &accel_core::Ray<f32>) -> Self {
        Self {
            origin: ray.origin.to_array(),
            t_min: ray.t_min,
            direction: ray.direction.to_array(),
            t_max: ray.t_max,
        }
    }
}

impl From<&abi::Ray> for accel_core::Ray<f32> {
    fn from(ray: &abi::Ray) -> Self {
        Self {
            t_min: ray.t_min,
            t_max: ray.t_max,
            ..Self::new(ray.origin.into(), ray.direction.into())
        }
    }
}
