//! A built structure as an object: one dynamic call for a batch of rays, everything inside static.

use crate::counters::{NoCounters, WorkCounters};
use crate::primitives::PrimSet;
use crate::ray::{Hit, Ray};
use crate::scalar::Scalar;
use crate::sink::{AnyHit, ClosestHit, HistoricalCellShadow, HistoricalShadow};
use crate::structures::{Shape, Structure};

/// What a shadow ray of the counting pass does; the historical rule is explained in
/// `results/published/README.md`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ShadowRule {
    /// Stops at the first opaque hit; transmissive primitives are ignored.
    OpaqueBlocks,
    /// As Havran and Sixta counted: glass that was hit is remembered and not tested again.
    Historical,
    /// As Havran and Sixta counted in the recursive grid: whatever is hit stops the ray, at once
    /// if the hit lies in the current cell.
    HistoricalInCell,
}

/// Answers of one historical shadow ray.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ShadowCount {
    /// An opaque primitive is in the way.
    pub blocked: bool,
    /// Distinct transmissive primitives hit before the walk ended.
    pub glass: u32,
}

/// A structure with the primitives it was built over.
///
/// Output slices must be as long as `rays`; longer inputs are cut to the shorter of both.
pub trait Tracer<S: Scalar>: Send + Sync {
    /// The closest hit of every ray.
    fn closest_hits(&self, rays: &[Ray<S>], hits: &mut [Hit<S>]);
    /// Whether every ray is blocked by an opaque primitive.
    fn occlusions(&self, rays: &[Ray<S>], blocked: &mut [bool]);
    /// [`Tracer::closest_hits`], counting the work.
    fn count_closest_hits(&self, rays: &[Ray<S>], hits: &mut [Hit<S>]) -> WorkCounters;
    /// [`Tracer::occlusions`], counting the work.
    fn count_occlusions(
        &self,
        rays: &[Ray<S>],
        rule: ShadowRule,
        answers: &mut [ShadowCount],
    ) -> WorkCounters;
    /// What was built.
    fn shape(&self) -> Shape;
}

/// The one implementation of [`Tracer`].
pub struct Bound<'a, P, T> {
    prims: &'a P,
    structure: T,
}

impl<'a, P, T> Bound<'a, P, T> {
    /// Joins a structure with the primitives it was built over.
    pub fn new(prims: &'a P, structure: T) -> Self {
        Self { prims, structure }
    }
}

impl<S: Scalar, P: PrimSet<S>, T: Structure<S>> Tracer<S> for Bound<'_, P, T> {
    fn closest_hits(&self, rays: &[Ray<S>], hits: &mut [Hit<S>]) {
        for (ray, hit) in rays.iter().zip(hits) {
            *hit = Hit { t: ray.t_max, ..Hit::NONE };
            if ray.is_traceable() {
                let mut sink = ClosestHit::<S, P, NoCounters>::new(self.prims, ray);
                self.structure.walk(ray, &mut sink);
                *hit = sink.finish().0;
            }
        }
    }

    fn occlusions(&self, rays: &[Ray<S>], blocked: &mut [bool]) {
        for (ray, blocked) in rays.iter().zip(blocked) {
            *blocked = ray.is_traceable() && {
                let mut sink = AnyHit::<S, P, NoCounters>::new(self.prims, ray);
                self.structure.walk(ray, &mut sink);
                sink.finish().0
            };
        }
    }

    fn count_closest_hits(&self, rays: &[Ray<S>], hits: &mut [Hit<S>]) -> WorkCounters {
        let mut total = WorkCounters::default();
        for (ray, hit) in rays.iter().zip(hits) {
            *hit = Hit { t: ray.t_max, ..Hit::NONE };
            if ray.is_traceable() {
                let mut sink = ClosestHit::<S, P, WorkCounters>::new(self.prims, ray);
                self.structure.walk(ray, &mut sink);
                let (found, counters) = sink.finish();
                *hit = found;
                total += counters;
            }
        }
        total
    }

    fn count_occlusions(
        &self,
        rays: &[Ray<S>],
        rule: ShadowRule,
        answers: &mut [ShadowCount],
    ) -> WorkCounters {
        let mut total = WorkCounters::default();
        for (ray, answer) in rays.iter().zip(answers) {
            *answer = ShadowCount { blocked: false, glass: 0 };
            if !ray.is_traceable() {
                continue;
            }
            match rule {
                ShadowRule::OpaqueBlocks => {
                    let mut sink = AnyHit::<S, P, WorkCounters>::new(self.prims, ray);
                    self.structure.walk(ray, &mut sink);
                    let (blocked, counters) = sink.finish();
                    answer.blocked = blocked;
                    total += counters;
                }
                ShadowRule::Historical => {
                    let mut sink = HistoricalShadow::<S, P, WorkCounters>::new(self.prims, ray);
                    self.structure.walk(ray, &mut sink);
                    let (blocked, glass, counters) = sink.finish();
                    *answer = ShadowCount { blocked, glass: glass as u32 };
                    total += counters;
                }
                ShadowRule::HistoricalInCell => {
                    let mut sink = HistoricalCellShadow::<S, P, WorkCounters>::new(self.prims, ray);
                    self.structure.walk(ray, &mut sink);
                    let (hit, counters) = sink.finish();
                    let glass = hit.is_hit() && !self.prims.is_opaque(hit.id);
                    *answer = ShadowCount { blocked: hit.is_hit() && !glass, glass: glass.into() };
                    total += counters;
                }
            }
        }
        total
    }

    fn shape(&self) -> Shape {
        self.structure.shape()
    }
}
