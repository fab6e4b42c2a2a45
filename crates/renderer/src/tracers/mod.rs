//! Tracers turn a scene into rays, cones or beams, and these into an image. One line each in
//! [`TRACERS`].

pub mod beam;
pub mod cone;
pub mod stages;
pub mod whitted;

use accel_core::region::{Gatherer, Work};
use accel_core::tracer::Tracer;
use scene_loading::Scene;

use crate::film::Image;

/// Every tracer: one line each.
pub static TRACERS: &[&TracerInfo] = &[&whitted::INFO, &cone::INFO, &beam::INFO];

/// What is known of a tracer.
#[derive(Debug)]
pub struct TracerInfo {
    /// Name as typed.
    pub name: &'static str,
    /// One line.
    pub summary: &'static str,
    /// Where it comes from.
    pub paper: &'static str,
    /// What it takes for granted, where it approximates.
    pub assumptions: &'static str,
    /// What it does differently from the paper.
    pub deviations: &'static str,
    /// What in a scene it refuses, with a [`Refusal`].
    pub refuses: &'static str,
}

/// The tracer of that name.
pub fn find(name: &str) -> Option<&'static TracerInfo> {
    TRACERS.iter().find(|t| t.name == name).copied()
}

/// A scene that a tracer cannot trace rightly, and so does not.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{tracer} tracing cannot do scene {scene}: it has {what}")]
pub struct Refusal {
    /// Name of the tracer.
    pub tracer: &'static str,
    /// Name of the scene.
    pub scene: String,
    /// What the scene has: `91 spheres`.
    pub what: String,
}

/// The structures over a scene's primitives, in f64; ids are the positions in
/// [`Scene::primitives`].
#[derive(Clone, Copy)]
pub struct Structures<'a> {
    /// Answers rays.
    pub rays: &'a dyn Tracer<f64>,
    /// Answers beams and cones.
    pub shafts: &'a dyn Gatherer,
}

/// How large an image is, and how deep.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Frame {
    /// Width and height in pixels.
    pub resolution: [u32; 2],
    /// Eye rays have depth 1; nothing is sent on from this depth.
    pub max_depth: u32,
}

/// An image by cones or beams.
#[derive(Debug, Clone, PartialEq)]
pub struct Drawn {
    /// The image.
    pub image: Image,
    /// What its candidate queries cost.
    pub work: Work,
    /// What else was counted, in the tracer's own words: `shadow beams`.
    pub counts: Vec<(&'static str, u64)>,
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
