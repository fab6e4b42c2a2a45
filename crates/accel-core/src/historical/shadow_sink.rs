//! Shadow rays as Havran and Sixta (1999) traced them, for counting only. What the published
//! figures say about them is explained in `results/published/README.md`.

use std::ops::ControlFlow;

use crate::geometry::ray::{Hit, MISS, Ray};
use crate::geometry::scalar::Scalar;
use crate::primitives::PrimSet;
use crate::query::counters::Counters;
use crate::query::sink::{Sink, count, count_steps};

/// The shadow ray of Havran and Sixta (1999): stops at the first opaque hit in list order, even
/// beyond the current cell; a transmissive primitive that was hit is remembered and not tested
/// again. Only used for counting.
pub struct HistoricalShadow<'a, S: Scalar, P: PrimSet<S>, C: Counters> {
    prims: &'a P,
    ray: &'a Ray<S>,
    setup: P::RaySetup,
    blocked: bool,
    glass: Vec<u32>,
    counters: C,
}

impl<'a, S: Scalar, P: PrimSet<S>, C: Counters> HistoricalShadow<'a, S, P, C> {
    pub fn new(prims: &'a P, ray: &'a Ray<S>) -> Self {
        Self {
            prims,
            ray,
            setup: prims.setup(ray),
            blocked: false,
            glass: Vec::new(),
            counters: C::default(),
        }
    }

    /// Blocked or not, the number of distinct transmissive primitives hit on the way, and what
    /// it took.
    pub fn finish(self) -> (bool, usize, C) {
        (self.blocked, self.glass.len(), self.counters)
    }
}

impl<S: Scalar, P: PrimSet<S>, C: Counters> Sink<S> for HistoricalShadow<'_, S, P, C> {
    count_steps!();

    #[inline(always)]
    fn is_any_hit(&self) -> bool {
        true
    }

    #[inline(always)]
    fn t_max(&self) -> S {
        self.ray.t_max
    }

    fn test(&mut self, ids: &[u32]) -> ControlFlow<()> {
        for &id in ids {
            if self.glass.contains(&id) {
                continue;
            }
            count!(self.counters.intersection_tests(1));
            if self.prims.intersect(id, self.ray, &self.setup, self.ray.t_max).is_some() {
                if self.prims.is_opaque(id) {
                    self.blocked = true;
                    return ControlFlow::Break(());
                }
                self.glass.push(id);
            }
        }
        ControlFlow::Continue(())
    }
}

/// The shadow ray of Havran and Sixta's (1999) recursive grid: every primitive stops it, glass too.
/// A hit within the current cell ends the query at once. A farther one is kept and ends the
/// traversal in its cell, after all of that cell's list: found again, it is no new hit. Only used
/// for counting.
pub struct HistoricalCellShadow<'a, S: Scalar, P: PrimSet<S>, C: Counters> {
    prims: &'a P,
    ray: &'a Ray<S>,
    setup: P::RaySetup,
    best: Hit<S>,
    counters: C,
}

impl<'a, S: Scalar, P: PrimSet<S>, C: Counters> HistoricalCellShadow<'a, S, P, C> {
    pub fn new(prims: &'a P, ray: &'a Ray<S>) -> Self {
        let best = Hit { t: ray.t_max, id: MISS };
        Self { prims, ray, setup: prims.setup(ray), best, counters: C::default() }
    }

    /// The blocker of the ray, and the counters.
    pub fn finish(self) -> (Hit<S>, C) {
        (self.best, self.counters)
    }
}

impl<S: Scalar, P: PrimSet<S>, C: Counters> Sink<S> for HistoricalCellShadow<'_, S, P, C> {
    count_steps!();

    #[inline(always)]
    fn t_max(&self) -> S {
        self.best.t
    }

    fn test(&mut self, ids: &[u32]) -> ControlFlow<()> {
        self.test_in_cell(ids, S::INFINITY)
    }

    fn test_in_cell(&mut self, ids: &[u32], t_exit: S) -> ControlFlow<()> {
        for &id in ids {
            count!(self.counters.intersection_tests(1));
            if let Some(t) = self.prims.intersect(id, self.ray, &self.setup, self.best.t)
                && t < self.best.t
            {
                self.best = Hit { t, id };
                if t <= t_exit {
                    return ControlFlow::Break(());
                }
            }
        }
        ControlFlow::Continue(())
    }
}
