//! Input and output of tracers without samples.

use accel_core::query::region::{FrustumQueries, FrustumWork};
use accel_core::query::tracer::Tracer;

use crate::film::Image;

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

/// An image by cones or beams.
#[derive(Debug, Clone, PartialEq)]
pub struct DrawnImage {
    pub image: Image,
    /// Cost of its candidate queries.
    pub work: FrustumWork,
    /// Further counters in the tracer's own words: `shadow beams`.
    pub counts: Vec<(&'static str, u64)>,
}
