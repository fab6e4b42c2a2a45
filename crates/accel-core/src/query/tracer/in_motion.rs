//! Tracing a set whose primitives move.
//!
//! A structure has one traversal for what counts, with the one [`ErasedSink`](crate::query::sink::ErasedSink), and one for what is
//! timed, with the one [`RelayedSink`](crate::query::sink::RelayedSink): motion costs no structure a traversal for each query and
//! mailbox. Where a structure's traversals are worth their time in the compiler (`COMPILED`), those
//! without a mailbox have the query itself compiled in, as those of scenes at rest have. Scenes at
//! rest are traced by [`Bound`](super::Bound) as ever.

use super::Tracer;
use super::erased::ErasedTracer;
use crate::geometry::far_ray;
use crate::geometry::ray::{Hit, Ray};
use crate::geometry::scalar::Scalar;
use crate::primitives::PrimSet;
use crate::query::batch::each_near;
use crate::query::cells::{CellVisitor, NoCells};
use crate::query::counters::{NoCounters, WorkCounters};
use crate::query::mailbox::Setting;
use crate::query::sink::{Answer, Query};
use crate::query::trace::TraversalTrace;
use crate::structure::{Structure, StructureStats};
use crate::structures::time_segments::TimeSegments;

/// Structures over a set in motion, one per segment of time. `COMPILED`: queries are compiled into
/// the traversals.
pub struct BoundInMotion<'a, S: Scalar, P, T, const COMPILED: bool> {
    prims: &'a P,
    segments: TimeSegments<'a, S, T>,
    mailbox: Setting,
    reach: S,
}

impl<'a, S: Scalar, P: PrimSet<S>, T: Structure<S>, const COMPILED: bool>
    BoundInMotion<'a, S, P, T, COMPILED>
{
    /// Joins structures with the primitives they were built over.
    pub fn new(prims: &'a P, segments: TimeSegments<'a, S, T>, mailbox: Setting) -> Self {
        let reach = far_ray::reach(prims.magnitude());
        Self { prims, segments, mailbox, reach }
    }

    fn erased(&self) -> ErasedTracer<'_, S, P> {
        ErasedTracer { prims: self.prims, reach: self.reach, structure: &self.segments }
    }

    /// The mailbox that rays are timed with.
    fn timed_mailbox(&self) -> Option<&Setting> {
        Some(&self.mailbox).filter(|mailbox| T::DUPLICATES && mailbox.is_used())
    }

    #[inline(always)]
    fn timed<A: Answer<S>>(&self, rays: &[Ray<S>], answers: &mut [A]) {
        let mailbox = self.timed_mailbox();
        if !COMPILED || mailbox.is_some() {
            return self.erased().timed(rays, answers, mailbox);
        }
        each_near(self.reach, rays, answers, |ray| {
            let query = Query::<S, P, NoCounters, A>::new(self.prims, ray);
            self.segments.traversed(ray, query).answer
        });
    }
}

impl<S: Scalar, P: PrimSet<S>, T: Structure<S>, const COMPILED: bool> Tracer<S>
    for BoundInMotion<'_, S, P, T, COMPILED>
{
    fn closest_hits(&self, rays: &[Ray<S>], hits: &mut [Hit<S>]) {
        self.timed(rays, hits);
    }

    fn occlusions(&self, rays: &[Ray<S>], blocked: &mut [bool]) {
        self.timed(rays, blocked);
    }

    fn count_closest_hits(&self, rays: &[Ray<S>], hits: &mut [Hit<S>]) -> WorkCounters {
        self.erased().counted(rays, hits, &self.mailbox)
    }

    fn count_occlusions(&self, rays: &[Ray<S>], blocked: &mut [bool]) -> WorkCounters {
        self.erased().counted(rays, blocked, &self.mailbox)
    }

    fn stats(&self) -> StructureStats {
        let stats = self.segments.stats();
        StructureStats { bytes: stats.bytes + self.mailbox.bytes(), ..stats }
    }

    /// Those of each segment, one after the other.
    fn cells(&self, each: &mut CellVisitor<'_>) -> Result<(), NoCells> {
        self.segments.cells(each)
    }

    fn trace(&self, ray: &Ray<S>) -> Result<TraversalTrace<S>, NoCells> {
        Ok(self.erased().trace(ray, &self.mailbox))
    }
}
