//! A sink as an object of which only tests are asked: for timed passes whose queries are not
//! compiled into each traversal.

use std::ops::ControlFlow;

use crate::geometry::scalar::Scalar;
use crate::primitives::TriangleBlock;
use crate::query::sink::Sink;

/// A sink behind one dynamic call a list. It counts no steps, and where the query ends stands here,
/// so that a traversal's steps call nothing.
pub(crate) struct RelayedSink<'a, S: Scalar> {
    query: &'a mut dyn Tests<S>,
    is_any_hit: bool,
    t_max: S,
}

impl<'a, S: Scalar> RelayedSink<'a, S> {
    /// Hides the type of a sink.
    #[inline(always)]
    pub(crate) fn new<K: Sink<S>>(query: &'a mut K) -> Self {
        Self { is_any_hit: query.is_any_hit(), t_max: query.t_max(), query }
    }
}

/// [`Sink::test`] as an object has it: where the query ends after it, or `None` if it is over.
trait Tests<S: Scalar> {
    fn tested(&mut self, ids: &[u32]) -> Option<S>;
    fn tested_block(&mut self, block: &TriangleBlock<S>) -> Option<S>;
    fn tested_blocks(&mut self, blocks: &[TriangleBlock<S>]) -> Option<S>;
}

impl<S: Scalar, K: Sink<S>> Tests<S> for K {
    fn tested(&mut self, ids: &[u32]) -> Option<S> {
        self.test(ids).is_continue().then(|| self.t_max())
    }

    fn tested_block(&mut self, block: &TriangleBlock<S>) -> Option<S> {
        self.test_block(block).is_continue().then(|| self.t_max())
    }

    fn tested_blocks(&mut self, blocks: &[TriangleBlock<S>]) -> Option<S> {
        self.test_blocks(blocks).is_continue().then(|| self.t_max())
    }
}

impl<S: Scalar> RelayedSink<'_, S> {
    #[inline(always)]
    fn goes_on_to(&mut self, t_max: Option<S>) -> ControlFlow<()> {
        match t_max {
            Some(t_max) => {
                self.t_max = t_max;
                ControlFlow::Continue(())
            }
            None => ControlFlow::Break(()),
        }
    }
}

impl<S: Scalar> Sink<S> for RelayedSink<'_, S> {
    const COUNTING: bool = false;

    #[inline(always)]
    fn t_max(&self) -> S {
        self.t_max
    }

    #[inline(always)]
    fn is_any_hit(&self) -> bool {
        self.is_any_hit
    }

    #[inline(always)]
    fn test(&mut self, ids: &[u32]) -> ControlFlow<()> {
        let t_max = self.query.tested(ids);
        self.goes_on_to(t_max)
    }

    #[inline(always)]
    fn test_block(&mut self, block: &TriangleBlock<S>) -> ControlFlow<()> {
        let t_max = self.query.tested_block(block);
        self.goes_on_to(t_max)
    }

    #[inline(always)]
    fn test_blocks(&mut self, blocks: &[TriangleBlock<S>]) -> ControlFlow<()> {
        let t_max = self.query.tested_blocks(blocks);
        self.goes_on_to(t_max)
    }

    #[inline(always)]
    fn elementary_step(&mut self, _: bool) {}

    #[inline(always)]
    fn inner_step(&mut self) {}
}
