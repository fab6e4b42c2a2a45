//! Queries as sinks: a traversal pushes candidates, the sink tests them and says when to stop.
//!
//! One traversal thus serves closest hit, occlusion and the historical shadow ray, with and
//! without counters.

use std::ops::ControlFlow;

use crate::geometry::far_ray::Parameters;
use crate::geometry::ray::{Hit, Ray};
use crate::geometry::scalar::Scalar;
use crate::primitives::{PrimSet, TriangleBlock};
use crate::query::counters::Counters;
use crate::query::mailbox::{Mailbox, NoMailbox};

/// The query, as a traversal sees it.
#[warn(missing_docs)]
pub trait Sink<S: Scalar> {
    /// True when the sink counts: lets an adapter skip work that is only done for counting.
    const COUNTING: bool;
    /// True where primitives are tested by another test than the default, to be compared with it:
    /// what a structure has for other comparisons is not compiled for it.
    const HAS_OTHER_TEST: bool = false;
    /// No hit beyond this parameter matters any more. A traversal stops once everything it has
    /// not visited lies strictly beyond it.
    fn t_max(&self) -> S;
    /// Tests the candidates; `Break` ends the query.
    fn test(&mut self, ids: &[u32]) -> ControlFlow<()>;
    /// [`Sink::test`] of the triangles of a block, at once where the set has a test for that. The
    /// block is made of triangles of the set that the sink tests.
    #[inline(always)]
    fn test_block(&mut self, block: &TriangleBlock<S>) -> ControlFlow<()> {
        let (ids, n) = block.ids();
        self.test(&ids[..n])
    }
    /// Tests the blocks of a list, which begins with the first of these; others may follow it.
    #[inline(always)]
    fn test_blocks(&mut self, blocks: &[TriangleBlock<S>]) -> ControlFlow<()> {
        for block in blocks {
            self.test_block(block)?;
            if !block.has_next() {
                break;
            }
        }
        ControlFlow::Continue(())
    }
    /// [`Sink::test`] for a query that treats hits up to the cell's exit differently from farther
    /// ones; `t_exit` is the parameter at which the ray leaves the cell of these candidates.
    #[inline(always)]
    fn test_in_cell(&mut self, ids: &[u32], _t_exit: S) -> ControlFlow<()> {
        self.test(ids)
    }
    /// True when any hit may end the query and none changes [`Sink::t_max`]: lets an adapter call
    /// the occlusion query of a library.
    #[inline(always)]
    fn is_any_hit(&self) -> bool {
        false
    }
    /// Reports a step into a cell or leaf.
    fn elementary_step(&mut self, empty: bool);
    /// Reports a step within a hierarchy.
    fn inner_step(&mut self);
}

mod erased;
mod relayed;

pub use erased::ErasedSink;
pub(crate) use relayed::RelayedSink;

/// What a query asks for: the closest hit ([`Hit`]), or whether an opaque primitive blocks the ray
/// (`bool`).
pub trait Answer<S: Scalar>: Copy {
    /// [`Sink::is_any_hit`] of its queries.
    const IS_ANY_HIT: bool;
    /// The answer for a ray that hits nothing.
    fn miss(ray: &Ray<S>) -> Self;
    /// [`Sink::t_max`] of a query of that answer so far.
    fn t_max(&self, ray: &Ray<S>) -> S;
    /// [`Sink::test`].
    fn test<P: PrimSet<S>, C: Counters, M: Mailbox>(
        query: &mut Query<'_, S, P, C, Self, M>,
        ids: &[u32],
    ) -> ControlFlow<()>;
    /// [`Sink::test_block`] of a query that neither counts nor has a mailbox.
    fn test_block<P: PrimSet<S>, C, M>(
        query: &mut Query<'_, S, P, C, Self, M>,
        block: &TriangleBlock<S>,
    ) -> ControlFlow<()>;
    /// The answer for the ray that the query's was made from; `None` stands for a miss.
    fn restored(self, parameters: Parameters<S>) -> Option<Self>;
    /// The answers of a batch.
    fn of_batch(answers: &mut [Self]) -> BatchAnswers<'_, S>;
}

/// Rays that are answered together.
#[derive(Debug)]
pub struct RayBatch<'a, S: Scalar> {
    /// As many as there are answers.
    pub rays: &'a [Ray<S>],
    /// How far from the scene's origin rays may start before they are brought near
    /// ([`crate::geometry::far_ray`]).
    pub reach: S,
    /// Where the answers go.
    pub answers: BatchAnswers<'a, S>,
}

/// Query kind of a batch, with one answer slot per ray.
#[derive(Debug)]
pub enum BatchAnswers<'a, S: Scalar> {
    /// Closest hits.
    Closest(&'a mut [Hit<S>]),
    /// True if an opaque primitive is in the way.
    Occlusion(&'a mut [bool]),
}

/// A query of a ray.
pub struct Query<'a, S: Scalar, P: PrimSet<S>, C, A, M = NoMailbox> {
    mailbox: M,
    pub(crate) prims: &'a P,
    pub(crate) ray: &'a Ray<S>,
    pub(crate) setup: P::RaySetup,
    /// The answer so far.
    pub(crate) answer: A,
    /// The counters so far.
    pub(crate) counters: C,
}

/// The closest hit in `[t_min, t_max]`; of equal hits the lowest id wins.
pub type ClosestHit<'a, S, P, C, M = NoMailbox> = Query<'a, S, P, C, Hit<S>, M>;

/// Is the ray blocked by an opaque primitive? Transmissive ones let it pass.
pub type AnyHit<'a, S, P, C, M = NoMailbox> = Query<'a, S, P, C, bool, M>;

impl<'a, S: Scalar, P: PrimSet<S>, C: Counters, A: Answer<S>> Query<'a, S, P, C, A> {
    #[inline(always)]
    pub fn new(prims: &'a P, ray: &'a Ray<S>) -> Self {
        Self::prepared(prims, ray, prims.setup(ray), NoMailbox)
    }
}

impl<'a, S: Scalar, P: PrimSet<S>, C: Counters, A: Answer<S>, M> Query<'a, S, P, C, A, M> {
    /// Starts a query with an empty mailbox.
    #[inline(always)]
    pub fn with_mailbox(prims: &'a P, ray: &'a Ray<S>, mailbox: M) -> Self {
        Self::prepared(prims, ray, prims.setup(ray), mailbox)
    }

    /// Starts a query of a ray that is prepared for the set.
    #[inline(always)]
    pub(crate) fn prepared(prims: &'a P, ray: &'a Ray<S>, setup: P::RaySetup, mailbox: M) -> Self {
        Self { mailbox, prims, ray, setup, answer: A::miss(ray), counters: C::default() }
    }

    /// The answer and what it took.
    #[inline(always)]
    pub fn finish(self) -> (A, C) {
        (self.answer, self.counters)
    }
}

impl<S: Scalar, P: PrimSet<S>, C: Counters, A: Answer<S>, M: Mailbox> Sink<S>
    for Query<'_, S, P, C, A, M>
{
    const COUNTING: bool = C::ENABLED;
    const HAS_OTHER_TEST: bool = P::HAS_OTHER_TESTS;

    #[inline(always)]
    fn elementary_step(&mut self, _empty: bool) {
        count!(self.counters.elementary_step(_empty));
    }

    #[inline(always)]
    fn inner_step(&mut self) {
        count!(self.counters.inner_step());
    }

    #[inline(always)]
    fn t_max(&self) -> S {
        self.answer.t_max(self.ray)
    }

    #[inline(always)]
    fn is_any_hit(&self) -> bool {
        A::IS_ANY_HIT
    }

    #[inline(always)]
    fn test(&mut self, ids: &[u32]) -> ControlFlow<()> {
        A::test(self, ids)
    }

    #[inline(always)]
    fn test_block(&mut self, block: &TriangleBlock<S>) -> ControlFlow<()> {
        if M::ENABLED || C::ENABLED {
            let (ids, n) = block.ids();
            return self.test(&ids[..n]);
        }
        A::test_block(self, block)
    }
}

impl<S: Scalar> Answer<S> for Hit<S> {
    const IS_ANY_HIT: bool = false;

    #[inline(always)]
    fn miss(ray: &Ray<S>) -> Self {
        Self { t: ray.t_max, ..Self::NONE }
    }

    #[inline(always)]
    fn t_max(&self, _: &Ray<S>) -> S {
        self.t
    }

    #[inline(always)]
    fn test<P: PrimSet<S>, C: Counters, M: Mailbox>(
        query: &mut ClosestHit<'_, S, P, C, M>,
        ids: &[u32],
    ) -> ControlFlow<()> {
        if !M::ENABLED {
            count!(query.counters.intersection_tests(ids.len()));
        }
        // what is read for each is in registers, also where the query itself is not
        let (prims, ray, mut best) = (query.prims, query.ray, query.answer);
        for &id in ids {
            if M::ENABLED {
                if !query.mailbox.is_new(id) {
                    count!(query.counters.test_saved());
                    continue;
                }
                count!(query.counters.intersection_tests(1));
            }
            if let Some(t) = prims.intersect(id, ray, &query.setup, best.t)
                && (t < best.t || id < best.id)
            {
                best = Hit { t, id };
            }
        }
        query.answer = best;
        ControlFlow::Continue(())
    }

    #[inline(always)]
    fn test_block<P: PrimSet<S>, C, M>(
        query: &mut ClosestHit<'_, S, P, C, M>,
        block: &TriangleBlock<S>,
    ) -> ControlFlow<()> {
        query.prims.closest_in_block(block, query.ray, &query.setup, &mut query.answer);
        ControlFlow::Continue(())
    }

    #[inline(always)]
    fn restored(self, parameters: Parameters<S>) -> Option<Self> {
        self.is_hit().then(|| Self { t: parameters.restored(self.t), ..self })
    }

    fn of_batch(answers: &mut [Self]) -> BatchAnswers<'_, S> {
        BatchAnswers::Closest(answers)
    }
}

impl<S: Scalar> Answer<S> for bool {
    const IS_ANY_HIT: bool = true;

    #[inline(always)]
    fn miss(_: &Ray<S>) -> Self {
        false
    }

    #[inline(always)]
    fn t_max(&self, ray: &Ray<S>) -> S {
        ray.t_max
    }

    #[inline(always)]
    fn test<P: PrimSet<S>, C: Counters, M: Mailbox>(
        query: &mut AnyHit<'_, S, P, C, M>,
        ids: &[u32],
    ) -> ControlFlow<()> {
        for &id in ids {
            if M::ENABLED && !query.mailbox.is_new(id) {
                count!(query.counters.test_saved());
                continue;
            }
            count!(query.counters.intersection_tests(1));
            let hit = query.prims.intersect(id, query.ray, &query.setup, query.ray.t_max);
            if hit.is_some() && query.prims.is_opaque(id) {
                query.answer = true;
                return ControlFlow::Break(());
            }
        }
        ControlFlow::Continue(())
    }

    #[inline(always)]
    fn test_block<P: PrimSet<S>, C, M>(
        query: &mut AnyHit<'_, S, P, C, M>,
        block: &TriangleBlock<S>,
    ) -> ControlFlow<()> {
        if query.prims.is_blocked_in(block, query.ray, &query.setup) {
            query.answer = true;
            return ControlFlow::Break(());
        }
        ControlFlow::Continue(())
    }

    #[inline(always)]
    fn restored(self, _: Parameters<S>) -> Option<Self> {
        Some(self)
    }

    fn of_batch(answers: &mut [Self]) -> BatchAnswers<'_, S> {
        BatchAnswers::Occlusion(answers)
    }
}

/// A call to the counters. The feature `delete-counter-calls` removes it from the source, so that
/// `scripts/counter-overhead.sh` can show that disabled counters cost nothing.
macro_rules! count {
    ($call:expr) => {
        #[cfg(not(feature = "delete-counter-calls"))]
        $call;
    };
}

/// Hands the steps of a sink around a `query` on to that.
macro_rules! steps_of_query {
    () => {
        #[inline(always)]
        fn elementary_step(&mut self, empty: bool) {
            self.query.elementary_step(empty);
        }
        #[inline(always)]
        fn inner_step(&mut self) {
            self.query.inner_step();
        }
    };
}

/// A sink around a `query` ends where that does.
macro_rules! end_of_query {
    () => {
        #[inline(always)]
        fn t_max(&self) -> S {
            self.query.t_max()
        }
        #[inline(always)]
        fn is_any_hit(&self) -> bool {
            self.query.is_any_hit()
        }
    };
}

pub(crate) use {count, end_of_query, steps_of_query};
