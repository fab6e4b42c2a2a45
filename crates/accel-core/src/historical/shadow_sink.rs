//! Shadow rays as Havran and Sixta (1999) traced them, for counting only. What the published
//! figures say about them is explained in `results/published/README.md`.

use std::ops::ControlFlow;

use crate::geometry::ray::{Hit, Ray};
use crate::geometry::scalar::Scalar;
use crate::primitives::PrimSet;
use crate::query::counters::Counters;
use crate::query::sink::{AnyHit, ClosestHit, Sink, count, end_of_query, steps_of_query};
use crate::query::tracer::ShadowCount;

/// The shadow ray of Havran and Sixta (1999): stops at the first opaque hit in list order, even
/// beyond the current cell; a transmissive primitive that was hit is remembered and not tested
/// again. Only used for counting.
pub struct HistoricalShadow<'a, S: Scalar, P: PrimSet<S>, C: Counters> {
    query: AnyHit<'a, S, P, C>,
    glass: Vec<u32>,
}

impl<'a, S: Scalar, P: PrimSet<S>, C: Counters> HistoricalShadow<'a, S, P, C> {
    pub fn new(prims: &'a P, ray: &'a Ray<S>) -> Self {
        Self { query: AnyHit::new(prims, ray), glass: Vec::new() }
    }

    /// The answer and what it took.
    pub fn finish(self) -> (ShadowCount, C) {
        let (blocked, counters) = self.query.finish();
        (ShadowCount { blocked, glass: self.glass.len() as u32 }, counters)
    }
}

impl<S: Scalar, P: PrimSet<S>, C: Counters> Sink<S> for HistoricalShadow<'_, S, P, C> {
    const COUNTING: bool = C::ENABLED;
    steps_of_query!();
    end_of_query!();

    fn test(&mut self, ids: &[u32]) -> ControlFlow<()> {
        for &id in ids {
            if self.glass.contains(&id) {
                continue;
            }
            let query = &mut self.query;
            count!(query.counters.intersection_tests(1));
            if query.prims.intersect(id, query.ray, &query.setup, query.ray.t_max).is_some() {
                if query.prims.is_opaque(id) {
                    query.answer = true;
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
    query: ClosestHit<'a, S, P, C>,
}

impl<'a, S: Scalar, P: PrimSet<S>, C: Counters> HistoricalCellShadow<'a, S, P, C> {
    pub fn new(prims: &'a P, ray: &'a Ray<S>) -> Self {
        Self { query: ClosestHit::new(prims, ray) }
    }

    /// The answer and what it took.
    pub fn finish(self) -> (ShadowCount, C) {
        let prims = self.query.prims;
        let (hit, counters) = self.query.finish();
        let is_glass = hit.is_hit() && !prims.is_opaque(hit.id);
        (ShadowCount { blocked: hit.is_hit() && !is_glass, glass: is_glass.into() }, counters)
    }
}

impl<S: Scalar, P: PrimSet<S>, C: Counters> Sink<S> for HistoricalCellShadow<'_, S, P, C> {
    const COUNTING: bool = C::ENABLED;
    steps_of_query!();
    end_of_query!();

    fn test(&mut self, ids: &[u32]) -> ControlFlow<()> {
        self.test_in_cell(ids, S::INFINITY)
    }

    fn test_in_cell(&mut self, ids: &[u32], t_exit: S) -> ControlFlow<()> {
        for &id in ids {
            let query = &mut self.query;
            count!(query.counters.intersection_tests(1));
            if let Some(t) = query.prims.intersect(id, query.ray, &query.setup, query.answer.t)
                && t < query.answer.t
            {
                query.answer = Hit { t, id };
                if t <= t_exit {
                    return ControlFlow::Break(());
                }
            }
        }
        ControlFlow::Continue(())
    }
}
