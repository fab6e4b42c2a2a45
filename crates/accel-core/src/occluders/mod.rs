//! What answers shadow rays only: "is this point hidden from this light?".
//!
//! An occluder is built for the lights of a scene and knows nothing of other rays, so it is no
//! [`crate::structure::Structure`] and has a registry of its own. Its answers are those of every
//! structure, bit for bit: it chooses which primitives to test, never how.

pub mod light_buffer;
mod nearest_light;
pub mod shadow_path;

pub use nearest_light::NearestLight;
pub use shadow_path::{BoxedOccluder, Occluder};

use glam::DVec3;

use crate::geometry::scalar::Scalar;
use crate::params::Params;
use crate::primitives::PrimsRef;
use crate::registry::{self, Buildable, RegistryItem};
use crate::structure::BuildError;

/// Every occluder of the workspace: one line each.
pub static REGISTRY: &[Entry] = &[occluder!(light_buffer::build, light_buffer::INFO)];

/// The registry of occluders, which answer shadow rays only.
pub struct OccluderRegistry;

impl RegistryItem for OccluderRegistry {
    type Builder<S: Scalar> = fn(&Params) -> PreparedOccluder<S>;
}

/// An occluder whose settings have been read. What is left is the build, which alone is timed.
pub type PreparedOccluder<S> = Box<
    dyn for<'a> Fn(PrimsRef<'a, S>, &[DVec3]) -> Result<BoxedOccluder<'a, S>, BuildError>
        + Send
        + Sync,
>;

/// One line of [`REGISTRY`].
pub type Entry = registry::Entry<OccluderRegistry>;

impl Entry {
    pub fn prepare<S: Buildable>(&self, params: &Params) -> PreparedOccluder<S> {
        S::builder(self)(params)
    }

    /// Builds the occluder over the set for point lights at these places.
    ///
    /// # Errors
    /// [`BuildError`].
    pub fn build<'a, S: Buildable>(
        &self,
        prims: PrimsRef<'a, S>,
        lights: &[DVec3],
        params: &Params,
    ) -> Result<BoxedOccluder<'a, S>, BuildError> {
        self.prepare(params)(prims, lights)
    }
}

/// The entry of that name.
pub fn find(name: &str) -> Option<&'static Entry> {
    registry::find(REGISTRY, name)
}

/// A registry entry for a generic build function and its description.
#[macro_export]
macro_rules! occluder {
    ($build:path, $info:path) => {
        $crate::occluders::Entry::new(
            &$info,
            |params| {
                let settings = $crate::params::config::Settings::of(params);
                Box::new(move |prims, lights| $build(prims, lights, &settings))
            },
            |params| {
                let settings = $crate::params::config::Settings::of(params);
                Box::new(move |prims, lights| $build(prims, lights, &settings))
            },
        )
    };
}
use occluder;
