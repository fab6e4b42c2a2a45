//! A structure with its primitives: what is timed is compiled for each structure, kind of primitive
//! and query, but for tests that are called anyway; what counts traverses with one [`ErasedSink`].

use super::erased::ErasedTracer;
use super::{KeptStructure, Parts, ShadowCount, ShadowRule, Tracer};
use crate::geometry::far_ray;
use crate::geometry::ray::{Hit, Ray};
use crate::geometry::scalar::Scalar;
use crate::primitives::PrimSet;
use crate::query::batch::{self, PlainStructure, RayByRay, each_near};
use crate::query::cells::{CellVisitor, NoCells};
use crate::query::counters::{Counters, NoCounters, WorkCounters};
use crate::query::kernel::ListBlocks;
use crate::query::mailbox::{MailboxSource, NoMailbox, Setting};
use crate::query::sink::{Answer, Query};
use crate::query::trace::TraversalTrace;
use crate::structure::{
    BatchAnswers, Batches, RayBatch, Structure, StructureStats, traverse_by_blocks,
};

/// A structure bound to its primitives: the [`Tracer`] of static scenes. Where `COMPILED`, queries
/// are compiled into the traversal; elsewhere each list that a traversal meets costs a dynamic
/// call, and batches are answered ray by ray.
pub struct Bound<'a, S, P, T, const COMPILED: bool> {
    prims: &'a P,
    parts: Parts<S, T>,
    mailbox: Setting,
    reach: S,
    is_updated: bool,
}

impl<'a, S: Scalar, P: PrimSet<S>, T: Structure<S>, const COMPILED: bool>
    Bound<'a, S, P, T, COMPILED>
{
    /// Whether queries with a mailbox are compiled: not for tests that are only compared.
    const HAS_COMPILED_MAILBOX: bool = T::DUPLICATES && !P::HAS_OTHER_TESTS;

    /// Joins a structure with the primitives it was built over.
    pub fn new(prims: &'a P, structure: T) -> Self {
        Self::of_parts(prims, Parts { structure, blocks: None }, Setting::None, false)
    }

    /// The same with a mailbox; `is_updated` where the structure was taken from the frame before.
    pub(crate) fn of_parts(
        prims: &'a P,
        parts: Parts<S, T>,
        mailbox: Setting,
        is_updated: bool,
    ) -> Self {
        Self { prims, parts, mailbox, reach: far_ray::reach(prims.magnitude()), is_updated }
    }

    #[inline(always)]
    fn one_by_one<A: Answer<S>, B: MailboxSource>(
        &self,
        rays: &[Ray<S>],
        answers: &mut [A],
        mut mailboxes: B,
    ) {
        each_near(self.reach, rays, answers, |ray| {
            let mailbox = mailboxes.next_ray();
            let mut query = Query::<S, P, NoCounters, A, _>::with_mailbox(self.prims, ray, mailbox);
            self.parts.structure.traverse(ray, &mut query);
            query.answer
        });
    }

    #[inline(always)]
    fn by_blocks<A: Answer<S>>(&self, blocks: &ListBlocks<S>, rays: &[Ray<S>], answers: &mut [A]) {
        let prims = self.prims;
        if self.parts.structure.batches(prims, Some(blocks)).are_together() {
            let NoCounters = self.answer_batch(Some(blocks), rays, A::of_batch(answers));
            return;
        }
        each_near(self.reach, rays, answers, |ray| {
            let mut query = Query::<S, P, NoCounters, A>::new(prims, ray);
            traverse_by_blocks(&self.parts.structure, blocks, ray, &mut query);
            query.answer
        });
    }

    #[inline(always)]
    fn timed<A: Answer<S>>(&self, rays: &[Ray<S>], answers: &mut [A]) {
        let n = rays.len().min(answers.len());
        let (rays, answers) = (&rays[..n], &mut answers[..n]);
        // the constants stand here: what they exclude is not compiled
        if !COMPILED {
            return self.erased().timed(rays, answers, self.timed_mailbox());
        }
        if T::HAS_LISTS
            && P::HAS_BLOCKS
            && let Some(blocks) = &self.parts.blocks
        {
            return self.by_blocks(blocks, rays, answers);
        }
        if Self::HAS_COMPILED_MAILBOX && self.mailbox.is_used() {
            return self.mailbox.with(|mailbox| self.one_by_one(rays, answers, mailbox));
        }
        match self.parts.structure.batches(self.prims, None) {
            Batches::RayByRay if T::HAS_AVX512 && P::HAS_BLOCKS => {
                let structure = &PlainStructure(&self.parts.structure);
                let batch = RayBatch { rays, reach: self.reach, answers: A::of_batch(answers) };
                batch::answer::<RayByRay, NoCounters, _, _, _>(structure, self.prims, batch, None);
            }
            Batches::RayByRay => self.one_by_one(rays, answers, NoMailbox),
            Batches::Together | Batches::Packets | Batches::Library => {
                let NoCounters = self.answer_batch(None, rays, A::of_batch(answers));
            }
        }
    }

    #[inline(always)]
    fn answer_batch<C: Counters>(
        &self,
        blocks: Option<&ListBlocks<S>>,
        rays: &[Ray<S>],
        answers: BatchAnswers<'_, S>,
    ) -> C {
        let batch = RayBatch { rays, reach: self.reach, answers };
        self.parts.structure.answer_batch(self.prims, blocks, batch)
    }

    /// Answers each ray; what it took. Packets are counted as they are timed.
    fn counted<A: Answer<S>>(&self, rays: &[Ray<S>], answers: &mut [A]) -> WorkCounters {
        if !COMPILED || self.parts.structure.batches(self.prims, None) != Batches::Packets {
            return self.erased().counted(rays, answers, &self.mailbox);
        }
        let n = rays.len().min(answers.len());
        self.answer_batch(None, &rays[..n], A::of_batch(&mut answers[..n]))
    }

    /// [`Tracer::count_closest_hits`] with a mailbox of the caller's, in place of that of the
    /// settings.
    pub fn count_closest<B: MailboxSource>(
        &self,
        rays: &[Ray<S>],
        hits: &mut [Hit<S>],
        mailboxes: B,
    ) -> WorkCounters {
        self.erased().counted_with(rays, hits, mailboxes)
    }

    fn erased(&self) -> ErasedTracer<'_, S, P> {
        ErasedTracer { prims: self.prims, reach: self.reach, structure: &self.parts }
    }

    /// The mailbox that rays are timed with: none where lists are blocks.
    fn timed_mailbox(&self) -> Option<&Setting> {
        let is_used = T::DUPLICATES && self.parts.blocks.is_none() && self.mailbox.is_used();
        is_used.then_some(&self.mailbox)
    }
}

impl<S: Scalar, P: PrimSet<S>, T: Structure<S>, const COMPILED: bool> Tracer<S>
    for Bound<'_, S, P, T, COMPILED>
{
    fn closest_hits(&self, rays: &[Ray<S>], hits: &mut [Hit<S>]) {
        self.timed(rays, hits);
    }

    fn occlusions(&self, rays: &[Ray<S>], blocked: &mut [bool]) {
        self.timed(rays, blocked);
    }

    fn count_closest_hits(&self, rays: &[Ray<S>], hits: &mut [Hit<S>]) -> WorkCounters {
        self.counted(rays, hits)
    }

    fn count_occlusions(&self, rays: &[Ray<S>], blocked: &mut [bool]) -> WorkCounters {
        self.counted(rays, blocked)
    }

    fn count_historical(
        &self,
        rays: &[Ray<S>],
        rule: ShadowRule,
        answers: &mut [ShadowCount],
    ) -> Result<WorkCounters, NoCells> {
        Ok(self.erased().historical(rays, rule, answers))
    }

    fn stats(&self) -> StructureStats {
        let stats = self.parts.stats();
        StructureStats { bytes: stats.bytes + self.mailbox.bytes(), ..stats }
    }

    fn cells(&self, each: &mut CellVisitor<'_>) -> Result<(), NoCells> {
        self.parts.structure.cells(each)
    }

    fn trace(&self, ray: &Ray<S>) -> Result<TraversalTrace<S>, NoCells> {
        Ok(self.erased().trace(ray, &self.mailbox))
    }

    fn released(self: Box<Self>) -> Option<KeptStructure> {
        Some(KeptStructure::new(self.parts, self.prims.len()))
    }

    fn is_updated(&self) -> bool {
        self.is_updated
    }

    fn batches(&self) -> Batches {
        if !COMPILED || self.timed_mailbox().is_some() {
            return Batches::RayByRay;
        }
        self.parts.structure.batches(self.prims, self.parts.blocks.as_ref())
    }

    fn code(&self) -> &'static str {
        std::any::type_name::<Self>()
    }
}
