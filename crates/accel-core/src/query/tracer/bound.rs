//! A structure with its primitives: what is timed is compiled for each structure, kind of primitive
//! and query, but for tests that are called anyway; what counts traverses with one [`ErasedSink`].

use super::counting::CountingTracer;
use super::nearby::{closest, near};
use super::timing::TimingTracer;
use super::{KeptStructure, Parts};
use super::{ShadowCount, ShadowRule, Tracer};
use crate::geometry::far_ray;
use crate::geometry::ray::{Hit, Ray};
use crate::geometry::scalar::Scalar;
use crate::memory::Limits;
use crate::memory::OutOfMemory;
use crate::primitives::PrimSet;
use crate::query::batch::{self, PlainStructure, RayByRay};
use crate::query::by_blocks;
use crate::query::cells::{CellVisitor, NoCells};
use crate::query::counters::{NoCounters, WorkCounters};
use crate::query::kernel::ListBlocks;
use crate::query::mailbox::{MailboxSource, NoMailbox, Setting};
use crate::query::sink::{AnyHit, ClosestHit, ErasedSink, RelayedSink};
use crate::query::trace::TraversalTrace;
use crate::structure::{BatchAnswers, Batches, Structure, StructureStats};
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
            self.blocks = by_blocks::of_structure(over, &self.structure, limits)?;
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
    fn timed_closest<B: MailboxSource>(&self, rays: &[Ray<S>], hits: &mut [Hit<S>], mailboxes: B) {
        closest::<S, B>(self.reach, rays, hits, mailboxes, |ray, mailbox| {
            let mut sink =
                ClosestHit::<S, P, NoCounters, _>::with_mailbox(self.prims, ray, mailbox);
            self.structure.traverse(ray, &mut sink);
            sink.finish().0
        });
    }

    #[inline(always)]
    fn closest_by_blocks(&self, blocks: &ListBlocks<S>, rays: &[Ray<S>], hits: &mut [Hit<S>]) {
        let prims = self.prims;
        if self.structure.batches(prims, Some(blocks)).are_together() {
            let answers = BatchAnswers::Closest(hits);
            return self.answer_batch(Some(blocks), rays, answers);
        }
        closest::<S, _>(self.reach, rays, hits, NoMailbox, |ray, _| {
            let mut query = ClosestHit::<S, P, NoCounters>::new(prims, ray);
            by_blocks::traverse(&self.structure, blocks, ray, &mut query);
            query.finish().0
        });
    }

    #[inline(always)]
    fn occlusions_by_blocks(&self, blocks: &ListBlocks<S>, rays: &[Ray<S>], blocked: &mut [bool]) {
        let prims = self.prims;
        if self.structure.batches(prims, Some(blocks)).are_together() {
            let answers = BatchAnswers::Occlusion(blocked);
            return self.answer_batch(Some(blocks), rays, answers);
        }
        for (ray, blocked) in rays.iter().zip(blocked) {
            *blocked = near(self.reach, ray, false, |ray, _| {
                let mut query = AnyHit::<S, P, NoCounters>::new(prims, ray);
                by_blocks::traverse(&self.structure, blocks, ray, &mut query);
                query.finish().0
            });
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

    /// How batches are answered by what is compiled.
    fn batches_of(&self, blocks: Option<&ListBlocks<S>>) -> Batches {
        if COMPILED { self.structure.batches(self.prims, blocks) } else { Batches::RayByRay }
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

    #[inline(always)]
    fn timed_occlusions<B: MailboxSource>(
        &self,
        rays: &[Ray<S>],
        blocked: &mut [bool],
        mut mailboxes: B,
    ) {
        for (ray, blocked) in rays.iter().zip(blocked) {
            *blocked = near(self.reach, ray, false, |ray, _| {
                let mailbox = mailboxes.next_ray();
                let mut sink =
                    AnyHit::<S, P, NoCounters, _>::with_mailbox(self.prims, ray, mailbox);
                self.structure.traverse(ray, &mut sink);
                sink.finish().0
            });
        }
    }

    fn count_all_closest(&self, rays: &[Ray<S>], hits: &mut [Hit<S>]) -> WorkCounters {
        self.counting(|counting| counting.all_closest(rays, hits, &self.mailbox))
    }

    fn count_all_occlusions(
        &self,
        rays: &[Ray<S>],
        rule: ShadowRule,
        answers: &mut [ShadowCount],
    ) -> WorkCounters {
        self.counting(|counting| counting.all_occlusions(rays, rule, answers, &self.mailbox))
    }

    fn trace_of(&self, ray: &Ray<S>) -> TraversalTrace<S> {
        self.counting(|counting| counting.trace_of(ray, &self.mailbox))
    }

    fn cells_of(&self, each: &mut CellVisitor<'_>) -> Result<(), NoCells> {
        self.structure.cells(each)
    }

    fn whole_shape(&self) -> StructureStats {
        let stats = self.structure.stats();
        let blocks = self.blocks.as_ref().map_or(0, ListBlocks::bytes);
        StructureStats { bytes: stats.bytes + self.mailbox.bytes() + blocks, ..stats }
    }
}

impl<S: Scalar, P: PrimSet<S>, T: Structure<S>, const COMPILED: bool> Tracer<S>
    for Bound<'_, S, P, T, COMPILED>
{
    fn closest_hits(&self, rays: &[Ray<S>], hits: &mut [Hit<S>]) {
        let n = rays.len().min(hits.len());
        let (rays, hits) = (&rays[..n], &mut hits[..n]);
        // the constants stand here: what they exclude is not compiled
        if !COMPILED {
            let mailbox = self.timed_mailbox();
            return self.relaying(|timing| timing.all_closest(rays, hits, mailbox));
        }
        if T::HAS_LISTS
            && P::HAS_BLOCKS
            && let Some(blocks) = &self.blocks
        {
            return self.closest_by_blocks(blocks, rays, hits);
        }
        if Self::HAS_COMPILED_MAILBOX && self.mailbox.is_used() {
            return self.mailbox.with(|mailbox| self.timed_closest(rays, hits, mailbox));
        }
        match self.structure.batches(self.prims, None) {
            Batches::RayByRay if T::HAS_AVX512 && P::HAS_BLOCKS => {
                let answers = BatchAnswers::Closest(hits);
                let structure = &PlainStructure(&self.structure);
                batch::answer::<RayByRay, NoCounters, _, _, _>(
                    structure, self.prims, rays, self.reach, answers,
                );
            }
            Batches::RayByRay => self.timed_closest(rays, hits, NoMailbox),
            Batches::Together | Batches::Packets | Batches::Library => {
                let answers = BatchAnswers::Closest(hits);
                self.answer_batch(None, rays, answers);
            }
        }
    }

    fn occlusions(&self, rays: &[Ray<S>], blocked: &mut [bool]) {
        let n = rays.len().min(blocked.len());
        let (rays, blocked) = (&rays[..n], &mut blocked[..n]);
        // the constants stand here: what they exclude is not compiled
        if !COMPILED {
            let mailbox = self.timed_mailbox();
            return self.relaying(|timing| timing.all_occlusions(rays, blocked, mailbox));
        }
        if T::HAS_LISTS
            && P::HAS_BLOCKS
            && let Some(blocks) = &self.blocks
        {
            return self.occlusions_by_blocks(blocks, rays, blocked);
        }
        if Self::HAS_COMPILED_MAILBOX && self.mailbox.is_used() {
            return self.mailbox.with(|mailbox| self.timed_occlusions(rays, blocked, mailbox));
        }
        match self.structure.batches(self.prims, None) {
            Batches::RayByRay if T::HAS_AVX512 && P::HAS_BLOCKS => {
                let answers = BatchAnswers::Occlusion(blocked);
                let structure = &PlainStructure(&self.structure);
                batch::answer::<RayByRay, NoCounters, _, _, _>(
                    structure, self.prims, rays, self.reach, answers,
                );
            }
            Batches::RayByRay => self.timed_occlusions(rays, blocked, NoMailbox),
            Batches::Together | Batches::Packets | Batches::Library => {
                let answers = BatchAnswers::Occlusion(blocked);
                self.answer_batch(None, rays, answers);
            }
        }
    }

    fn count_closest_hits(&self, rays: &[Ray<S>], hits: &mut [Hit<S>]) -> WorkCounters {
        if !COMPILED || self.structure.batches(self.prims, None) != Batches::Packets {
            return self.count_all_closest(rays, hits);
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
            return self.count_all_occlusions(rays, rule, answers);
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
        self.whole_shape()
    }

    fn cells(&self, each: &mut CellVisitor<'_>) -> Result<(), NoCells> {
        self.cells_of(each)
    }

    fn trace(&self, ray: &Ray<S>) -> Result<TraversalTrace<S>, NoCells> {
        Ok(self.trace_of(ray))
    }

    fn released(self: Box<Self>) -> Option<KeptStructure> {
        let Self { prims, structure, blocks, .. } = *self;
        Some(KeptStructure::new(Parts { structure, blocks, primitives: prims.len() }))
    }

    fn is_updated(&self) -> bool {
        self.is_updated
    }

    fn batches(&self) -> Batches {
        match self.timed_mailbox() {
            Some(_) => Batches::RayByRay,
            None => self.batches_of(self.blocks.as_ref()),
        }
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
