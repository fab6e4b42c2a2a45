//! A built structure as an object: one dynamic call for a batch of rays, everything inside static.

use crate::counters::{Counters, NoCounters, WorkCounters};
use crate::far_ray::{self, Place};
use crate::primitives::PrimSet;
use crate::ray::{Hit, Ray};
use crate::scalar::Scalar;
use crate::sink::{AnyHit, ClosestHit, HistoricalShadow};
use crate::structures::{Shape, Structure};

/// What a shadow ray of the counting pass does; the historical rule is explained in
/// `results/published/README.md`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ShadowRule {
    /// Stops at the first opaque hit; transmissive primitives are ignored.
    OpaqueBlocks,
    /// As Havran and Sixta counted: glass that was hit is remembered and not tested again.
    Historical,
}

/// Answers of one historical shadow ray.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
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
pub struct Bound<'a, S, P, T> {
    prims: &'a P,
    structure: T,
    reach: S,
}

impl<'a, S: Scalar, P: PrimSet<S>, T: Structure<S>> Bound<'a, S, P, T> {
    /// Joins a structure with the primitives it was built over.
    pub fn new(prims: &'a P, structure: T) -> Self {
        Self { prims, structure, reach: far_ray::reach(prims.magnitude()) }
    }

    #[inline(always)]
    fn closest<C: Counters>(&self, ray: &Ray<S>) -> (Hit<S>, C) {
        let mut sink = ClosestHit::<S, P, C>::new(self.prims, ray);
        self.structure.walk(ray, &mut sink);
        sink.finish()
    }

    #[inline(always)]
    fn any<C: Counters>(&self, ray: &Ray<S>) -> (bool, C) {
        let mut sink = AnyHit::<S, P, C>::new(self.prims, ray);
        self.structure.walk(ray, &mut sink);
        sink.finish()
    }

    fn historical(&self, ray: &Ray<S>) -> (ShadowCount, WorkCounters) {
        let mut sink = HistoricalShadow::<S, P, WorkCounters>::new(self.prims, ray);
        self.structure.walk(ray, &mut sink);
        let (blocked, glass, counters) = sink.finish();
        (ShadowCount { blocked, glass: glass as u32 }, counters)
    }

    #[inline(always)]
    fn closest_hits_with<C: Counters>(
        &self,
        rays: &[Ray<S>],
        hits: &mut [Hit<S>],
        mut add: impl FnMut(C),
    ) {
        for (ray, hit) in rays.iter().zip(hits) {
            let (found, counters) = match far_ray::place(ray, self.reach) {
                Place::Near => self.closest::<C>(ray),
                Place::Moved(near, by) => {
                    let (found, counters) = self.closest::<C>(&near);
                    (Hit { t: found.t + by, ..found }, counters)
                }
                Place::Nowhere => (Hit::NONE, C::default()),
            };
            *hit = if found.is_hit() { found } else { Hit { t: ray.t_max, ..Hit::NONE } };
            add(counters);
        }
    }
}

impl<S: Scalar, P: PrimSet<S>, T: Structure<S>> Tracer<S> for Bound<'_, S, P, T> {
    fn closest_hits(&self, rays: &[Ray<S>], hits: &mut [Hit<S>]) {
        self.closest_hits_with::<NoCounters>(rays, hits, |_| {});
    }

    fn occlusions(&self, rays: &[Ray<S>], blocked: &mut [bool]) {
        for (ray, blocked) in rays.iter().zip(blocked) {
            *blocked = match far_ray::place(ray, self.reach) {
                Place::Near => self.any::<NoCounters>(ray).0,
                Place::Moved(near, _) => self.any::<NoCounters>(&near).0,
                Place::Nowhere => false,
            };
        }
    }

    fn count_closest_hits(&self, rays: &[Ray<S>], hits: &mut [Hit<S>]) -> WorkCounters {
        let mut total = WorkCounters::default();
        self.closest_hits_with::<WorkCounters>(rays, hits, |c| total += c);
        total
    }

    fn count_occlusions(
        &self,
        rays: &[Ray<S>],
        rule: ShadowRule,
        answers: &mut [ShadowCount],
    ) -> WorkCounters {
        let mut total = WorkCounters::default();
        let one = |ray: &Ray<S>| match rule {
            ShadowRule::OpaqueBlocks => {
                let (blocked, counters) = self.any::<WorkCounters>(ray);
                (ShadowCount { blocked, glass: 0 }, counters)
            }
            ShadowRule::Historical => self.historical(ray),
        };
        for (ray, answer) in rays.iter().zip(answers) {
            let counters;
            (*answer, counters) = match far_ray::place(ray, self.reach) {
                Place::Near => one(ray),
                Place::Moved(near, _) => one(&near),
                Place::Nowhere => Default::default(),
            };
            total += counters;
        }
        total
    }

    fn shape(&self) -> Shape {
        self.structure.shape()
    }
}
