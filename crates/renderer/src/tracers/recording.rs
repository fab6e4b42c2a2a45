//! The rays of a scene, recorded once, so that every structure can be asked the same.

use accel_core::query::tracer::Tracer;
use accel_core::registry::Buildable;
use rayon::prelude::*;
use scene_loading::Scene;

use super::whitted::{TracedRow, Whitted};
use crate::rays::{RayBatches, RaySettings};

/// Traces the scene with `tracer` and keeps every ray it took. Runs in the current rayon pool;
/// the rays do not depend on the number of threads.
pub fn generate_rays<S: Buildable>(
    scene: &Scene,
    tracer: &dyn Tracer<S>,
    settings: &RaySettings,
) -> RayBatches<S> {
    let whitted = Whitted::new(scene, settings);
    let rows: Vec<TracedRow<S>> =
        (0..whitted.rows()).into_par_iter().map(|y| whitted.trace_row(tracer, y)).collect();
    let mut all = RayBatches::default();
    for rays in rows.into_iter().filter_map(|row| row.rays) {
        all.append(rays);
    }
    all
}
