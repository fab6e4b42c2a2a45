//! Descriptions of tracers, and of scenes that they do not support; input and output of those
//! without samples.

use accel_core::query::region::{FrustumQueries, FrustumWork};
use accel_core::query::tracer::Tracer;
use scene_loading::Scene;

use crate::film::Image;

#[derive(Debug)]
pub struct TracerInfo {
    pub name: &'static str,
    pub summary: &'static str,
    /// Where it comes from.
    pub paper: &'static str,
    pub assumptions: &'static str,
    /// Deviations from the paper.
    pub deviations: &'static str,
    /// Unsupported parts of scenes, answered with a [`Refusal`].
    pub refuses: &'static str,
}

/// A scene that a tracer cannot trace rightly, and so does not.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{tracer} tracing does not support scene {scene}: it has {what}")]
pub struct Refusal {
    pub tracer: &'static str,
    pub scene: String,
    /// The unsupported part: `91 spheres`.
    pub what: String,
}

impl Refusal {
    /// Refuses the scene if it has any of `what`.
    ///
    /// # Errors
    /// [`Refusal`] unless `count` is 0.
    pub fn of(
        tracer: &'static TracerInfo,
        scene: &Scene,
        count: usize,
        what: &str,
    ) -> Result<(), Self> {
        if count == 0 {
            return Ok(());
        }
        let what = format!("{count} {what}");
        Err(Self { tracer: tracer.name, scene: scene.name.clone(), what })
    }
}

/// The structures over a scene's primitives, in f64; ids are the positions in
/// `Scene::primitives`.
#[derive(Clone, Copy)]
pub struct Structures<'a> {
    pub rays: &'a dyn Tracer<f64>,
    /// Answers beams and cones.
    pub frusta: &'a dyn FrustumQueries,
}

/// How large an image is, and how deep.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Frame {
    /// Width and height in pixels.
    pub resolution: [u32; 2],
    /// Eye rays have depth 1; nothing is sent on from this depth.
    pub max_depth: u32,
}

#[derive(Debug, Clone, PartialEq)]
pub struct DrawnImage {
    pub image: Image,
    /// Cost of its candidate queries.
    pub work: FrustumWork,
    /// Further counters in the tracer's own words: `shadow beams`.
    pub counts: Vec<(&'static str, u64)>,
}

/// Declares what a tracer counts in an image, each with its name in reports.
macro_rules! counts {
    ($($(#[$about:meta])* $field:ident: $name:literal,)*) => {
        /// Numbers of an image's bundles, and of what became of them.
        #[derive(Debug, Clone, Copy, Default)]
        pub struct Counts {
            $($(#[$about])* pub $field: u64,)*
        }

        impl Counts {
            /// What the image that is drawn says of them.
            pub fn rows(self) -> Vec<(&'static str, u64)> {
                vec![$(($name, self.$field),)*]
            }
        }

        impl std::ops::AddAssign for Counts {
            fn add_assign(&mut self, other: Self) {
                $(self.$field += other.$field;)*
            }
        }
    };
}
pub(super) use counts;
