//! Answers of occluders, and an occluder as the shadow path of a renderer: a tracer whose closest
//! hits come from a structure and whose shadow rays go to the occluder.

use glam::DVec3;

use crate::geometry::ray::{Hit, Ray};
use crate::geometry::scalar::Scalar;
use crate::occluders::nearest_light::NearestLight;
use crate::query::counters::WorkCounters;
use crate::query::tracer::Tracer;
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

/// A structure and an occluder over the same primitives, as one tracer.
pub struct ShadowPath<'a, S: Scalar> {
    structure: Box<dyn Tracer<S> + 'a>,
    occluder: BoxedOccluder<'a, S>,
    lights: NearestLight,
}

impl<'a, S: Scalar> ShadowPath<'a, S> {
    /// Joins them; `lights` are those that the occluder was built for, in the same order.
    pub fn new(
        structure: Box<dyn Tracer<S> + 'a>,
        occluder: BoxedOccluder<'a, S>,
        lights: &[DVec3],
    ) -> Self {
        Self { structure, occluder, lights: NearestLight::new(lights) }
    }
}

impl<S: Scalar> Tracer<S> for ShadowPath<'_, S> {
    fn closest_hits(&self, rays: &[Ray<S>], hits: &mut [Hit<S>]) {
        self.structure.closest_hits(rays, hits);
    }

    fn occlusions(&self, rays: &[Ray<S>], blocked: &mut [bool]) {
        self.occluder.occlusions(rays, &self.lights.of_each(rays), blocked);
    }

    fn count_closest_hits(&self, rays: &[Ray<S>], hits: &mut [Hit<S>]) -> WorkCounters {
        self.structure.count_closest_hits(rays, hits)
    }

    fn count_occlusions(&self, rays: &[Ray<S>], blocked: &mut [bool]) -> WorkCounters {
        self.occluder.count_occlusions(rays, &self.lights.of_each(rays), blocked)
    }

    fn stats(&self) -> StructureStats {
        let stats = self.structure.stats();
        StructureStats { bytes: stats.bytes + self.occluder.stats().bytes, ..stats }
    }
}
