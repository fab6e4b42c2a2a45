//! The passes that reach the structure through one dynamic call per ray: those that count, and the
//! timed ones of queries that are not compiled into the traversal, as in most sets that move, and in
//! f64 of most structures.

use super::{ShadowCount, ShadowRule, Traversals};
use crate::geometry::ray::{Hit, Ray};
use crate::geometry::scalar::Scalar;
use crate::historical::shadow_sink::{HistoricalCellShadow, HistoricalShadow};
use crate::primitives::PrimSet;
use crate::query::batch::{each_near, rebase_origin};
use crate::query::counters::{NoCounters, WorkCounters};
use crate::query::kernel::BlockSink;
use crate::query::mailbox::{MailboxSource, NoMailbox, Setting};
use crate::query::sink::{Answer, ClosestHit, ErasedSink, Query, RelayedSink, Sink};
use crate::query::trace::{Recorder, TraversalTrace};

/// A structure's traversals with the primitives it was built over.
pub(super) struct ErasedTracer<'a, S: Scalar, P> {
    pub prims: &'a P,
    /// How far origins may be; see [`crate::geometry::far_ray`].
    pub reach: S,
    pub structure: &'a dyn Traversals<S>,
}

// Mailboxes are taken out here, too: a structure would have its own code for each.
impl<S: Scalar, P: PrimSet<S>> ErasedTracer<'_, S, P> {
    /// [`ErasedTracer::counted_with`] the mailbox of the settings.
    pub fn counted<A: Answer<S>>(
        &self,
        rays: &[Ray<S>],
        answers: &mut [A],
        mailbox: &Setting,
    ) -> WorkCounters {
        mailbox.with(|mailbox| self.counted_with(rays, answers, mailbox))
    }

    /// Answers each ray; what it took.
    pub fn counted_with<A: Answer<S>, B: MailboxSource>(
        &self,
        rays: &[Ray<S>],
        answers: &mut [A],
        mut mailboxes: B,
    ) -> WorkCounters {
        let mut total = WorkCounters::default();
        each_near(self.reach, rays, answers, |ray| {
            let mailbox = mailboxes.next_ray();
            let mut query =
                Query::<S, P, WorkCounters, A, _>::with_mailbox(self.prims, ray, mailbox);
            self.structure.counted(ray, ErasedSink::new(&mut query));
            let (answer, counters) = query.finish();
            total += counters;
            answer
        });
        total
    }

    /// The closest hit of a ray, and the trace to it.
    pub fn trace(&self, ray: &Ray<S>, mailbox: &Setting) -> TraversalTrace<S> {
        let (mut hits, mut steps, mut total) = ([Hit::NONE], Vec::new(), WorkCounters::default());
        mailbox.with(|mut mailboxes| {
            each_near(self.reach, std::slice::from_ref(ray), &mut hits, |ray| {
                let query = ClosestHit::with_mailbox(self.prims, ray, mailboxes.next_ray());
                let mut recorder = Recorder { query, steps: Vec::new() };
                self.structure.counted(ray, ErasedSink::new(&mut recorder));
                (steps, total) = (recorder.steps, recorder.query.counters);
                recorder.query.answer
            });
        });
        TraversalTrace { steps, hit: hits[0], counters: total }
    }

    /// Answers each historical shadow ray, which has no mailbox; what it took.
    pub fn historical(
        &self,
        rays: &[Ray<S>],
        rule: ShadowRule,
        answers: &mut [ShadowCount],
    ) -> WorkCounters {
        let mut total = WorkCounters::default();
        for (ray, answer) in rays.iter().zip(answers) {
            *answer = ShadowCount::default();
            let mut moved = None;
            let Some((ray, _)) = rebase_origin(ray, self.reach, &mut moved) else { continue };
            let counters: WorkCounters;
            (*answer, counters) = match rule {
                ShadowRule::Historical => {
                    let mut sink = HistoricalShadow::new(self.prims, ray);
                    self.structure.counted(ray, ErasedSink::new(&mut sink));
                    sink.finish()
                }
                ShadowRule::HistoricalInCell => {
                    let mut sink = HistoricalCellShadow::new(self.prims, ray);
                    self.structure.counted(ray, ErasedSink::new(&mut sink));
                    sink.finish()
                }
            };
            total += counters;
        }
        total
    }

    /// Answers each ray, with the mailbox of the settings if there is one.
    pub fn timed<A: Answer<S>>(
        &self,
        rays: &[Ray<S>],
        answers: &mut [A],
        mailbox: Option<&Setting>,
    ) {
        match mailbox {
            None => self.one_by_one(rays, answers, NoMailbox),
            Some(mailbox) => mailbox.with(|mailbox| self.one_by_one(rays, answers, mailbox)),
        }
    }

    fn one_by_one<A: Answer<S>, B: MailboxSource>(
        &self,
        rays: &[Ray<S>],
        answers: &mut [A],
        mut mailboxes: B,
    ) {
        each_near(self.reach, rays, answers, |ray| {
            let mailbox = mailboxes.next_ray();
            let query = Query::<S, P, NoCounters, A, _>::with_mailbox(self.prims, ray, mailbox);
            self.traversed(ray, query).answer
        });
    }

    /// The query after the traversal.
    #[inline(always)]
    fn traversed<K: Sink<S>>(&self, ray: &Ray<S>, mut query: K) -> K {
        match self.structure.blocks(ray) {
            Some(blocks) => {
                let mut sink = BlockSink { blocks, query: &mut query };
                self.structure.relayed(ray, RelayedSink::new(&mut sink));
            }
            None => self.structure.relayed(ray, RelayedSink::new(&mut query)),
        }
        query
    }
}
