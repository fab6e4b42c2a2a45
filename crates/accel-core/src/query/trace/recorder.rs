//! Writes down what a counted query is told.

use std::ops::ControlFlow;

use super::{TestResult, TraceStep};
use crate::geometry::ray::Hit;
use crate::geometry::scalar::Scalar;
use crate::primitives::PrimSet;
use crate::query::cells::CellKind;
use crate::query::counters::WorkCounters;
use crate::query::mailbox::Mailbox;
use crate::query::sink::{ClosestHit, Sink};

/// A counted closest-hit query that remembers.
pub(crate) struct Recorder<'a, S: Scalar, P: PrimSet<S>, M> {
    query: ClosestHit<'a, S, P, WorkCounters, M>,
    steps: Vec<TraceStep>,
}

impl<'a, S: Scalar, P: PrimSet<S>, M: Mailbox> Recorder<'a, S, P, M> {
    pub(crate) fn new(query: ClosestHit<'a, S, P, WorkCounters, M>) -> Self {
        Self { query, steps: Vec::new() }
    }

    /// The steps, the answer and what the query counted.
    pub(crate) fn finish(self) -> (Vec<TraceStep>, Hit<S>, WorkCounters) {
        let (hit, counters) = self.query.finish();
        (self.steps, hit, counters)
    }

    fn step(&mut self, kind: CellKind) {
        self.steps.push(TraceStep { kind, tests: Vec::new() });
    }
}

impl<S: Scalar, P: PrimSet<S>, M: Mailbox> Sink<S> for Recorder<'_, S, P, M> {
    const COUNTING: bool = true;

    fn t_max(&self) -> S {
        self.query.t_max()
    }

    fn test(&mut self, ids: &[u32]) -> ControlFlow<()> {
        for &id in ids {
            let (before, spared) = (self.query.answer, self.query.counters.tests_saved);
            self.query.test(&[id])?;
            let outcome = if self.query.counters.tests_saved > spared {
                TestResult::Spared
            } else if self.query.answer != before {
                TestResult::Hit
            } else {
                TestResult::Missed
            };
            if let Some(step) = self.steps.last_mut() {
                step.tests.push((id, outcome));
            }
        }
        ControlFlow::Continue(())
    }

    fn elementary_step(&mut self, empty: bool) {
        self.query.elementary_step(empty);
        self.step(if empty { CellKind::Empty } else { CellKind::Leaf });
    }

    fn inner_step(&mut self) {
        self.query.inner_step();
        self.step(CellKind::Inner);
    }
}
