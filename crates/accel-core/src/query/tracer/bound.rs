//! A structure with its primitives: what is timed is compiled for each structure, kind of primitive
//! and query, but for tests that are called anyway; what counts traverses with one [`ErasedSink`].

use super::counting::CountingTracer;
use super::nearby::each_near;
use super::timing::TimingTracer;
use super::{KeptStructure, Parts, ShadowCount, ShadowRule, Tracer};
use crate::geometry::far_ray;
use crate::geometry::ray::{Hit, Ray};
use crate::geometry::scalar::Scalar;
use crate::memory::{Limits, OutOfMemory};
use crate::primitives::PrimSet;
use crate::query::batch::{self, PlainStructure, RayByRay};
use crate::query::cells::{CellVisitor, NoCells};
use crate::query::counters::{NoCounters, WorkCounters};
use crate::query::kernel::ListBlocks;
use crate::query::mailbox::{MailboxSource, NoMailbox, Setting};
use crate::query::sink::{Answer, ErasedSink, Query, RelayedSink};
use crate::query::trace::TraversalTrace;
use crate::structure::{
    BatchAnswers, Batches, Structure, StructureStats, blocks_of, traverse_by_blocks,
};
use crate::update::{Change, ChangedLists};

/// A structure bound to its primitives: the [`Tracer`] of static scenes. Where `COMPILED`, queries
/// are compiled into the traversal; elsewhere each list that a traversal meets costs a dynamic
/// call, and batches are answered ray by ray.
pub struct Bound<'a, S, P, T, const COMPILED: bool> {
    prims: &'a P,
    structure: T,
    mailbox: Setting,
    blocks: Option<ListBlocks<S>>,
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
        let reach = far_ray::reach(prims.magnitude());
        Self { prims, structure, mailbox: Setting::None, blocks: None, reach, is_updated: false }
    }

    /// The same with a mailbox.
    pub fn with_mailbox(self, mailbox: Setting) -> Self {
        Self { mailbox, ..self }
    }

    /// The same with the lists of the structure as blocks, where it has lists and blocks serve
    /// `over`: the set that it was built over, or the same primitives under the default tests.
    ///
    /// # Errors
    /// [`OutOfMemory`] where memory does not allow them.
    pub fn with_blocks<B: PrimSet<S>>(
        mut self,
        over: &B,
        limits: Limits,
    ) -> Result<Self, OutOfMemory> {
        if P::HAS_BLOCKS {
            self.blocks = blocks_of(over, &self.structure, limits)?;
        }
        Ok(self)
    }

    /// The same, whose structure was taken from the frame before, as `change` says.
    pub(crate) fn updated(self, change: &Change) -> Self {
        Self { is_updated: !matches!(change, Change::Rebuilt), ..self }
    }

    /// [`Bound::with_blocks`] where there were blocks in the frame before, and some lists have
    /// changed since.
    ///
    /// # Errors
    /// [`OutOfMemory`].
    pub(crate) fn with_changed_blocks<B: PrimSet<S>>(
        mut self,
        over: &B,
        limits: Limits,
        blocks: ListBlocks<S>,
        changed: &ChangedLists,
    ) -> Result<Self, OutOfMemory> {
        let mut lists = Vec::new();
        self.structure.lists(&mut |list| lists.push(list));
        limits.fits(ListBlocks::<S>::bytes_for(&lists))?;
        self.blocks = blocks.changed(over, &lists, changed);
        Ok(self)
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
            self.structure.traverse(ray, &mut query);
            query.answer
        });
    }

    #[inline(always)]
    fn by_blocks<A: Answer<S>>(&self, blocks: &ListBlocks<S>, rays: &[Ray<S>], answers: &mut [A]) {
        let prims = self.prims;
        if self.structure.batches(prims, Some(blocks)).are_together() {
            return self.answer_batch(Some(blocks), rays, A::of_batch(answers));
        }
        each_near(self.reach, rays, answers, |ray| {
            let mut query = Query::<S, P, NoCounters, A>::new(prims, ray);
            traverse_by_blocks(&self.structure, blocks, ray, &mut query);
            query.answer
        });
    }

    #[inline(always)]
    fn timed<A: Answer<S>>(&self, rays: &[Ray<S>], answers: &mut [A]) {
        let n = rays.len().min(answers.len());
        let (rays, answers) = (&rays[..n], &mut answers[..n]);
        // the constants stand here: what they exclude is not compiled
        if !COMPILED {
            let mailbox = self.timed_mailbox();
            return self.relaying(|timing| timing.all(rays, answers, mailbox));
        }
        if T::HAS_LISTS
            && P::HAS_BLOCKS
            && let Some(blocks) = &self.blocks
        {
            return self.by_blocks(blocks, rays, answers);
        }
        if Self::HAS_COMPILED_MAILBOX && self.mailbox.is_used() {
            return self.mailbox.with(|mailbox| self.one_by_one(rays, answers, mailbox));
        }
        match self.structure.batches(self.prims, None) {
            Batches::RayByRay if T::HAS_AVX512 && P::HAS_BLOCKS => {
                let (structure, answers) = (&PlainStructure(&self.structure), A::of_batch(answers));
                batch::answer::<RayByRay, NoCounters, _, _, _>(
                    structure, self.prims, rays, self.reach, answers,
                );
            }
            Batches::RayByRay => self.one_by_one(rays, answers, NoMailbox),
            Batches::Together | Batches::Packets | Batches::Library => {
                self.answer_batch(None, rays, A::of_batch(answers));
            }
        }
    }

    #[inline(always)]
    fn answer_batch(
        &self,
        blocks: Option<&ListBlocks<S>>,
        rays: &[Ray<S>],
        answers: BatchAnswers<'_, S>,
    ) {
        let (prims, reach) = (self.prims, self.reach);
        let NoCounters = self.structure.answer_batch(prims, blocks, rays, reach, answers);
    }

    /// [`Tracer::count_closest_hits`] with a mailbox of the caller's, in place of that of the
    /// settings.
    pub fn count_closest<B: MailboxSource>(
        &self,
        rays: &[Ray<S>],
        hits: &mut [Hit<S>],
        mailboxes: B,
    ) -> WorkCounters {
        self.counting(|counting| counting.closest_hits(rays, hits, mailboxes))
    }

    fn counting<R>(&self, pass: impl FnOnce(CountingTracer<'_, S, P>) -> R) -> R {
        let traversal = |ray: &Ray<S>, sink: ErasedSink<'_, S>| {
            super::traverse_counted(&self.structure, ray, sink)
        };
        pass(CountingTracer { prims: self.prims, reach: self.reach, traversal: &traversal })
    }

    /// The mailbox that rays are timed with: none where lists are blocks.
    fn timed_mailbox(&self) -> Option<&Setting> {
        let is_used = T::DUPLICATES && self.blocks.is_none() && self.mailbox.is_used();
        is_used.then_some(&self.mailbox)
    }

    /// For queries that are not compiled into the traversal.
    fn relaying<R>(&self, pass: impl FnOnce(TimingTracer<'_, S, P>) -> R) -> R {
        let traversal = |ray: &Ray<S>, sink: RelayedSink<'_, S>| {
            super::traverse_relayed(&self.structure, ray, sink)
        };
        let blocks = |_: &Ray<S>| self.blocks.as_ref();
        pass(TimingTracer {
            prims: self.prims,
            reach: self.reach,
            traversal: &traversal,
            blocks: &blocks,
        })
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
        if !COMPILED || self.structure.batches(self.prims, None) != Batches::Packets {
            return self.counting(|counting| counting.all_closest(rays, hits, &self.mailbox));
        }
        let n = rays.len().min(hits.len());
        let (rays, answers) = (&rays[..n], BatchAnswers::Closest(&mut hits[..n]));
        self.structure.answer_batch(self.prims, None, rays, self.reach, answers)
    }

    fn count_occlusions(
        &self,
        rays: &[Ray<S>],
        rule: ShadowRule,
        answers: &mut [ShadowCount],
    ) -> WorkCounters {
        let batches = self.structure.batches(self.prims, None);
        if !COMPILED || batches != Batches::Packets || rule != ShadowRule::OpaqueBlocks {
            return self
                .counting(|counting| counting.all_occlusions(rays, rule, answers, &self.mailbox));
        }
        let n = rays.len().min(answers.len());
        let mut blocked: Vec<bool> = answers[..n].iter().map(|answer| answer.blocked).collect();
        let of_batch = BatchAnswers::Occlusion(&mut blocked);
        let rays = &rays[..n];
        let work = self.structure.answer_batch(self.prims, None, rays, self.reach, of_batch);
        for (answer, blocked) in answers.iter_mut().zip(blocked) {
            *answer = ShadowCount { blocked, glass: 0 };
        }
        work
    }

    fn stats(&self) -> StructureStats {
        let stats = self.structure.stats();
        let blocks = self.blocks.as_ref().map_or(0, ListBlocks::bytes);
        StructureStats { bytes: stats.bytes + self.mailbox.bytes() + blocks, ..stats }
    }

    fn cells(&self, each: &mut CellVisitor<'_>) -> Result<(), NoCells> {
        self.structure.cells(each)
    }

    fn trace(&self, ray: &Ray<S>) -> Result<TraversalTrace<S>, NoCells> {
        Ok(self.counting(|counting| counting.trace_of(ray, &self.mailbox)))
    }

    fn released(self: Box<Self>) -> Option<KeptStructure> {
        let Self { prims, structure, blocks, .. } = *self;
        Some(KeptStructure::new(Parts { structure, blocks, primitives: prims.len() }))
    }

    fn is_updated(&self) -> bool {
        self.is_updated
    }

    fn batches(&self) -> Batches {
        if !COMPILED || self.timed_mailbox().is_some() {
            return Batches::RayByRay;
        }
        self.structure.batches(self.prims, self.blocks.as_ref())
    }

    fn code(&self) -> &'static str {
        std::any::type_name::<Self>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::params::config::Settings;
    use crate::query::mailbox::{Slots, Stamps};
    use crate::structures::test_scenes::{mixed_scene, rays};
    use crate::structures::uniform_grid::{INFO, UniformGrid};

    #[test]
    fn ray_numbers_may_wrap() {
        // HARD_CASES Gr8: 8-bit numbers, more than 1,000 rays, down to one slot
        let set = mixed_scene::<f64>(200, 21, [1.0; 3]);
        let rays = rays(&set, 1500, 22);
        let params = INFO.defaults().set("density", 8).unwrap();
        let grid = UniformGrid::build(&set, &Settings::of(&params)).unwrap();
        let bound = Bound::<_, _, _, true>::new(&set, grid);
        let mut expected = vec![Hit::NONE; rays.len()];
        bound.closest_hits(&rays, &mut expected);
        let mut saved = Vec::new();
        let mut check =
            |name: &str, mailbox: &mut dyn FnMut(&mut [Hit<f64>], &mut WorkCounters)| {
                let (mut hits, mut total) = (vec![Hit::NONE; rays.len()], WorkCounters::default());
                mailbox(&mut hits, &mut total);
                assert_eq!(hits, expected, "{name}");
                saved.push(total.tests_saved);
            };
        let mut stamps = Stamps::<u8>::dense(200);
        check("dense", &mut |h, c| *c = bound.count_closest(&rays, h, &mut stamps));
        let mut stamps = Stamps::<u8>::in_records(200, 40);
        check("records", &mut |h, c| *c = bound.count_closest(&rays, h, &mut stamps));
        let mut stamps = Stamps::<u32>::dense(200);
        check("u32", &mut |h, c| *c = bound.count_closest(&rays, h, &mut stamps));
        let mut slots = Slots::<u8>::new(1 << 12);
        check("many slots", &mut |h, c| *c = bound.count_closest(&rays, h, &mut slots));
        let mut slots = Slots::<u8>::new(1);
        check("one slot", &mut |h, c| *c = bound.count_closest(&rays, h, &mut slots));
        assert!(saved[0] > 0 && saved[..4].iter().all(|&s| s == saved[0]), "{saved:?}");
        assert!(saved[4] < saved[0], "{saved:?}");
    }
}
