//! The work of an image: what its rays cost the structure, in all or by pixel.

use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use accel_core::query::counters::WorkCounters;
use accel_core::query::tracer::Tracer;
use accel_core::registry::Buildable;
use accel_core::structure::StructureStats;
use accel_core::{Hit, Ray};
use rayon::prelude::*;
use scene_loading::Scene;

use super::whitted::Whitted;
use crate::effects::EffectPlan;

/// A tracer that counts whatever it is asked for. Slower than the one it asks.
pub struct CountingTracer<'a, S: Buildable> {
    tracer: &'a dyn Tracer<S>,
    total: Mutex<WorkCounters>,
}

impl<'a, S: Buildable> CountingTracer<'a, S> {
    pub fn new(tracer: &'a dyn Tracer<S>) -> Self {
        Self { tracer, total: Mutex::default() }
    }

    pub fn total(&self) -> WorkCounters {
        *self.total.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn add(&self, work: WorkCounters) -> WorkCounters {
        *self.total.lock().unwrap_or_else(PoisonError::into_inner) += work;
        work
    }
}

impl<S: Buildable> Tracer<S> for CountingTracer<'_, S> {
    fn closest_hits(&self, rays: &[Ray<S>], hits: &mut [Hit<S>]) {
        self.count_closest_hits(rays, hits);
    }

    fn occlusions(&self, rays: &[Ray<S>], blocked: &mut [bool]) {
        self.count_occlusions(rays, blocked);
    }

    fn count_closest_hits(&self, rays: &[Ray<S>], hits: &mut [Hit<S>]) -> WorkCounters {
        self.add(self.tracer.count_closest_hits(rays, hits))
    }

    fn count_occlusions(&self, rays: &[Ray<S>], blocked: &mut [bool]) -> WorkCounters {
        self.add(self.tracer.count_occlusions(rays, blocked))
    }

    fn stats(&self) -> StructureStats {
        self.tracer.stats()
    }
}

/// Work of each pixel of an image, row by row: intersection tests, traversal steps, nanoseconds
/// from a pass of its own that does not count. Traces pixel by pixel, in the current rayon pool;
/// `now` is read before and after each.
pub fn pixel_work<S: Buildable>(
    scene: &Scene,
    tracer: &dyn Tracer<S>,
    plan: &EffectPlan,
    now: &(dyn Fn() -> Duration + Sync),
) -> [Vec<f64>; 3] {
    let whitted = Whitted::planned(scene, plan);
    let (width, height) = (whitted.columns(), whitted.rows());
    let one = |y: u32, x: u32| {
        let counted = CountingTracer::new(tracer);
        whitted.trace_columns(&counted, y, x..x + 1, None);
        let work = counted.total();
        let start = now();
        whitted.trace_columns(tracer, y, x..x + 1, None);
        let time = now().saturating_sub(start);
        [work.intersection_tests as f64, work.traversal_steps as f64, time.as_nanos() as f64]
    };
    let rows: Vec<Vec<[f64; 3]>> =
        (0..height).into_par_iter().map(|y| (0..width).map(|x| one(y, x)).collect()).collect();
    let pixels = rows.concat();
    std::array::from_fn(|k| pixels.iter().map(|pixel| pixel[k]).collect())
}
