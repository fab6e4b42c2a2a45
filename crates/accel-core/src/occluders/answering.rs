//! Answers of occluders.

use crate::geometry::ray::Ray;
use crate::geometry::scalar::Scalar;
use crate::query::counters::WorkCounters;
use crate::structure::{Batches, StructureStats};

/// A built occluder with the primitives it was built over; one dynamic call for a batch of rays.
///
/// Slices are cut to the shortest of them.
pub trait Occluder<S: Scalar>: Send + Sync {
    /// Writes for each ray whether an opaque primitive blocks it. `lights` says which light of
    /// the build each ray runs to; a ray that does not end there is answered too, only slower.
    fn occlusions(&self, rays: &[Ray<S>], lights: &[u32], blocked: &mut [bool]);
    /// [`Occluder::occlusions`], counting the work.
    fn count_occlusions(
        &self,
        rays: &[Ray<S>],
        lights: &[u32],
        blocked: &mut [bool],
    ) -> WorkCounters;
    /// Statistics over all lights.
    fn stats(&self) -> StructureStats;
    /// How a batch is answered while nothing is counted.
    fn batches(&self) -> Batches {
        Batches::RayByRay
    }
}

/// A boxed occluder over a set of primitives.
pub type BoxedOccluder<'a, S> = Box<dyn Occluder<S> + 'a>;
