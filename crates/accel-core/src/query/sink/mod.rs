//! Queries as sinks: a traversal pushes candidates, the sink tests them and says when to stop.
//!
//! One traversal thus serves closest hit, occlusion and the historical shadow ray, with and
//! without counters.

use std::ops::ControlFlow;

use crate::geometry::ray::{Hit, MISS, Ray};
use crate::geometry::scalar::Scalar;
use crate::primitives::{PrimSet, TriangleBlock};
use crate::query::counters::Counters;
use crate::query::mailbox::{Mailbox, NoMailbox};

/// The query, as a traversal sees it.
#[warn(missing_docs)]
pub trait Sink<S: Scalar> {
    /// True when the sink counts: lets an adapter skip work that is only done for counting.
    const COUNTING: bool;
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

/// The closest hit in `[t_min, t_max]`; of equal hits the lowest id wins.
pub struct ClosestHit<'a, S: Scalar, P: PrimSet<S>, C: Counters, M = NoMailbox> {
    mailbox: M,
    prims: &'a P,
    ray: &'a Ray<S>,
    setup: P::RaySetup,
    best: Hit<S>,
    counters: C,
}

impl<'a, S: Scalar, P: PrimSet<S>, C: Counters> ClosestHit<'a, S, P, C> {
    #[inline(always)]
    pub fn new(prims: &'a P, ray: &'a Ray<S>) -> Self {
        Self::prepared(prims, ray, prims.setup(ray))
    }

    /// Starts a query of a ray that is prepared for the set.
    #[inline(always)]
    pub(crate) fn prepared(prims: &'a P, ray: &'a Ray<S>, setup: P::RaySetup) -> Self {
        Self::with_setup(prims, ray, setup, NoMailbox)
    }
}

impl<'a, S: Scalar, P: PrimSet<S>, C: Counters, M: Mailbox> ClosestHit<'a, S, P, C, M> {
    /// Starts a query with an empty mailbox.
    #[inline(always)]
    pub fn with_mailbox(prims: &'a P, ray: &'a Ray<S>, mailbox: M) -> Self {
        Self::with_setup(prims, ray, prims.setup(ray), mailbox)
    }

    #[inline(always)]
    fn with_setup(prims: &'a P, ray: &'a Ray<S>, setup: P::RaySetup, mailbox: M) -> Self {
        let best = Hit { t: ray.t_max, id: MISS };
        Self { mailbox, prims, ray, setup, best, counters: C::default() }
    }

    /// The answer so far.
    #[inline(always)]
    pub(crate) fn hit(&self) -> Hit<S> {
        self.best
    }

    /// The counters so far.
    #[inline(always)]
    pub(crate) fn counters(&self) -> C {
        self.counters
    }

    /// The answer and what it took.
    #[inline(always)]
    pub fn finish(self) -> (Hit<S>, C) {
        (self.best, self.counters)
    }
}

impl<S: Scalar, P: PrimSet<S>, C: Counters, M: Mailbox> Sink<S> for ClosestHit<'_, S, P, C, M> {
    count_steps!();

    #[inline(always)]
    fn t_max(&self) -> S {
        self.best.t
    }

    #[inline(always)]
    fn test(&mut self, ids: &[u32]) -> ControlFlow<()> {
        if !M::ENABLED {
            count!(self.counters.intersection_tests(ids.len()));
        }
        // what is read for each is in registers, also where the sink itself is not
        let (prims, ray, mut best) = (self.prims, self.ray, self.best);
        for &id in ids {
            if M::ENABLED {
                if !self.mailbox.is_new(id) {
                    count!(self.counters.test_saved());
                    continue;
                }
                count!(self.counters.intersection_tests(1));
            }
            if let Some(t) = prims.intersect(id, ray, &self.setup, best.t)
                && (t < best.t || id < best.id)
            {
                best = Hit { t, id };
            }
        }
        self.best = best;
        ControlFlow::Continue(())
    }

    #[inline(always)]
    fn test_block(&mut self, block: &TriangleBlock<S>) -> ControlFlow<()> {
        if M::ENABLED || C::ENABLED {
            let (ids, n) = block.ids();
            return self.test(&ids[..n]);
        }
        self.prims.closest_in_block(block, self.ray, &self.setup, &mut self.best);
        ControlFlow::Continue(())
    }
}

/// Is the ray blocked by an opaque primitive? Transmissive ones let it pass.
pub struct AnyHit<'a, S: Scalar, P: PrimSet<S>, C: Counters, M = NoMailbox> {
    mailbox: M,
    prims: &'a P,
    ray: &'a Ray<S>,
    setup: P::RaySetup,
    blocked: bool,
    counters: C,
}

impl<'a, S: Scalar, P: PrimSet<S>, C: Counters> AnyHit<'a, S, P, C> {
    #[inline(always)]
    pub fn new(prims: &'a P, ray: &'a Ray<S>) -> Self {
        Self::prepared(prims, ray, prims.setup(ray))
    }

    /// Starts a query of a ray that is prepared for the set.
    #[inline(always)]
    pub(crate) fn prepared(prims: &'a P, ray: &'a Ray<S>, setup: P::RaySetup) -> Self {
        Self::with_setup(prims, ray, setup, NoMailbox)
    }
}

impl<'a, S: Scalar, P: PrimSet<S>, C: Counters, M: Mailbox> AnyHit<'a, S, P, C, M> {
    /// Starts a query with an empty mailbox.
    #[inline(always)]
    pub fn with_mailbox(prims: &'a P, ray: &'a Ray<S>, mailbox: M) -> Self {
        Self::with_setup(prims, ray, prims.setup(ray), mailbox)
    }

    #[inline(always)]
    fn with_setup(prims: &'a P, ray: &'a Ray<S>, setup: P::RaySetup, mailbox: M) -> Self {
        Self { mailbox, prims, ray, setup, blocked: false, counters: C::default() }
    }

    /// The answer so far.
    #[inline(always)]
    pub(crate) fn is_blocked(&self) -> bool {
        self.blocked
    }

    /// The counters so far.
    #[inline(always)]
    pub(crate) fn counters(&self) -> C {
        self.counters
    }

    /// The answer and what it took.
    #[inline(always)]
    pub fn finish(self) -> (bool, C) {
        (self.blocked, self.counters)
    }
}

impl<S: Scalar, P: PrimSet<S>, C: Counters, M: Mailbox> Sink<S> for AnyHit<'_, S, P, C, M> {
    count_steps!();

    #[inline(always)]
    fn is_any_hit(&self) -> bool {
        true
    }

    #[inline(always)]
    fn t_max(&self) -> S {
        self.ray.t_max
    }

    #[inline(always)]
    fn test(&mut self, ids: &[u32]) -> ControlFlow<()> {
        for &id in ids {
            if M::ENABLED && !self.mailbox.is_new(id) {
                count!(self.counters.test_saved());
                continue;
            }
            count!(self.counters.intersection_tests(1));
            let hit = self.prims.intersect(id, self.ray, &self.setup, self.ray.t_max);
            if hit.is_some() && self.prims.is_opaque(id) {
                self.blocked = true;
                return ControlFlow::Break(());
            }
        }
        ControlFlow::Continue(())
    }

    #[inline(always)]
    fn test_block(&mut self, block: &TriangleBlock<S>) -> ControlFlow<()> {
        if M::ENABLED || C::ENABLED {
            let (ids, n) = block.ids();
            return self.test(&ids[..n]);
        }
        if self.prims.is_blocked_in(block, self.ray, &self.setup) {
            self.blocked = true;
            return ControlFlow::Break(());
        }
        ControlFlow::Continue(())
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

macro_rules! count_steps {
    () => {
        const COUNTING: bool = C::ENABLED;
        #[inline(always)]
        fn elementary_step(&mut self, _empty: bool) {
            count!(self.counters.elementary_step(_empty));
        }
        #[inline(always)]
        fn inner_step(&mut self) {
            count!(self.counters.inner_step());
        }
    };
}

pub(crate) use {count, count_steps};
