//! Tracers turn a scene into rays, cones or beams, and these into an image. One line each in
//! [`TRACERS`].

pub mod beam;
pub mod cone;
mod info;
pub mod whitted;
pub mod work;

use accel_core::query::tracer::Tracer;
use accel_core::registry::Buildable;
use rayon::prelude::*;
use scene_loading::Scene;

pub use info::{DrawnImage, Frame, Refusal, Structures, TracerInfo};

use crate::rays::{RayBatches, RaySettings};
use whitted::{TracedRow, Whitted};

pub static TRACERS: &[&TracerInfo] = &[&whitted::INFO, &cone::INFO, &beam::INFO];

pub fn find(name: &str) -> Option<&'static TracerInfo> {
    TRACERS.iter().find(|t| t.name == name).copied()
}

/// Traces the scene with `tracer` and keeps every ray it took, so that every structure can be asked
/// the same. Runs in the current rayon pool;
/// the rays do not depend on the number of threads.
pub fn generate_rays<S: Buildable>(
    scene: &Scene,
    tracer: &dyn Tracer<S>,
    settings: &RaySettings,
) -> RayBatches<S> {
    let whitted = Whitted::new(scene, settings);
    let kept = || Some(RayBatches::default());
    let row = |y| whitted.trace_columns(tracer, y, 0..whitted.columns(), kept());
    let rows: Vec<TracedRow<S>> = (0..whitted.rows()).into_par_iter().map(row).collect();
    let mut all = RayBatches::default();
    for row in rows {
        all.total_internal_reflections += row.counts.total_internal_reflections;
        all.append(row.rays.unwrap_or_default());
    }
    all
}
