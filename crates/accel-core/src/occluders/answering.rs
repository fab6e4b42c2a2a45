//! What an occluder answers.

use glam::DVec3;

use crate::geometry::ray::Ray;
use crate::geometry::scalar::{Scalar, Vector};
use crate::query::counters::WorkCounters;
use crate::structure::Shape;

/// A built occluder with the primitives it was built over; one dynamic call for a batch of rays.
///
/// Slices are cut to the shortest of them.
pub trait Occluder<S: Scalar>: Send + Sync {
    /// Whether every ray is blocked by an opaque primitive. `lights` says which light of the build
    /// each ray runs to; a ray that does not end there is answered too, only slower.
    fn occlusions(&self, rays: &[Ray<S>], lights: &[u32], blocked: &mut [bool]);
    /// [`Occluder::occlusions`], counting the work.
    fn count_occlusions(
        &self,
        rays: &[Ray<S>],
        lights: &[u32],
        blocked: &mut [bool],
    ) -> WorkCounters;
    /// What was built, over all lights.
    fn shape(&self) -> Shape;
}

/// A boxed occluder over a set of primitives.
pub type BoxedOccluder<'a, S> = Box<dyn Occluder<S> + 'a>;

/// The light nearest to where a shadow ray ends, for [`Occluder::occlusions`]; 0 without lights.
pub fn nearest_light<S: Scalar>(ray: &Ray<S>, lights: &[DVec3]) -> u32 {
    let end = ray.at(ray.t_max).to_dvec3();
    let mut nearest = (0, f64::INFINITY);
    for (i, light) in lights.iter().enumerate() {
        let distance = light.distance_squared(end);
        if distance < nearest.1 {
            nearest = (i as u32, distance);
        }
    }
    nearest.0
}
