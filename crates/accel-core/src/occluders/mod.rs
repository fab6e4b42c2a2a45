//! What answers shadow rays only: "is this point hidden from this light?".
//!
//! An occluder is built for the lights of a scene and knows nothing of other rays, so it is no
//! [`crate::structures::Structure`] and has a registry of its own. Its answers are those of every
//! structure, bit for bit: it chooses which primitives to test, never how.

pub mod light_buffer;
pub mod shadow_path;

use glam::DVec3;

use crate::counters::WorkCounters;
use crate::params::{ParamError, Params};
use crate::ray::Ray;
use crate::scalar::{Scalar, Vector};
use crate::structures::{BuildError, PrimsRef, Shape, StructureInfo};

/// Every occluder of the workspace: one line each.
pub static REGISTRY: &[Entry] = &[occluder!(light_buffer::build, light_buffer::INFO)];

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
    /// Whether several rays of a batch are on their way at once, as in
    /// [`Tracer::answers_batches`](crate::tracer::Tracer::answers_batches).
    fn answers_batches(&self) -> bool {
        false
    }
}

/// A boxed occluder over a set of primitives.
pub type BoxedOccluder<'a, S> = Box<dyn Occluder<S> + 'a>;

type Builder<S> =
    for<'a> fn(PrimsRef<'a, S>, &[DVec3], &Params) -> Result<BoxedOccluder<'a, S>, BuildError>;

/// One line of the registry.
pub struct Entry {
    /// What it says of itself.
    pub info: &'static StructureInfo,
    build_f32: Builder<f32>,
    build_f64: Builder<f64>,
}

impl Entry {
    /// Used by [`occluder!`](crate::occluder).
    pub const fn new(
        info: &'static StructureInfo,
        build_f32: Builder<f32>,
        build_f64: Builder<f64>,
    ) -> Self {
        Self { info, build_f32, build_f64 }
    }

    /// Validates settings.
    ///
    /// # Errors
    /// [`ParamError`] naming what is valid.
    pub fn params<'s>(
        &self,
        settings: impl IntoIterator<Item = (&'s str, &'s str)>,
    ) -> Result<Params, ParamError> {
        Params::new(self.info.name, self.info.params, settings)
    }

    /// Builds the occluder over the set for point lights at these places.
    ///
    /// # Errors
    /// [`BuildError`].
    pub fn build<'a, S: OccluderScalar>(
        &self,
        prims: PrimsRef<'a, S>,
        lights: &[DVec3],
        params: &Params,
    ) -> Result<BoxedOccluder<'a, S>, BuildError> {
        S::builder(self)(prims, lights, params)
    }
}

/// The scalars that registry entries have builders for.
pub trait OccluderScalar: Scalar {
    /// The entry's builder for this scalar.
    fn builder(entry: &Entry) -> Builder<Self>;
}

impl OccluderScalar for f32 {
    fn builder(entry: &Entry) -> Builder<f32> {
        entry.build_f32
    }
}

impl OccluderScalar for f64 {
    fn builder(entry: &Entry) -> Builder<f64> {
        entry.build_f64
    }
}

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

/// The entry of that name.
pub fn find(name: &str) -> Option<&'static Entry> {
    REGISTRY.iter().find(|e| e.info.name == name)
}

/// A registry entry for a generic build function and its description.
#[macro_export]
macro_rules! occluder {
    ($build:path, $info:path) => {
        $crate::occluders::Entry::new(
            &$info,
            |prims, lights, params| $build(prims, lights, params),
            |prims, lights, params| $build(prims, lights, params),
        )
    };
}
use occluder;
