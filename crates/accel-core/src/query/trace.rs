//! Trace of one ray through a structure: the steps of the counted traversal, in their order.
//!
//! It is written down by a sink around the counted query, through the one
//! [`ErasedSink`](crate::query::sink::ErasedSink) that counting passes traverse with: the traversal
//! is that which is counted. A sink is not told where the ray is;
//! [`entered`](crate::query::entered) finds that.

use std::ops::ControlFlow;

use crate::geometry::ray::Hit;
use crate::geometry::scalar::Scalar;
use crate::primitives::PrimSet;
use crate::query::cells::CellKind;
use crate::query::counters::WorkCounters;
use crate::query::mailbox::Mailbox;
use crate::query::sink::{ClosestHit, Sink};

/// Result of the test of a primitive.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TestResult {
    /// No hit, or none nearer than the one before.
    Missed,
    /// The nearest hit so far.
    Hit,
    /// A mailbox spared the test.
    Spared,
}

/// A traversal step, and the tests that it led to.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TraceStep {
    pub kind: CellKind,
    /// Primitives in the order of their tests.
    pub tests: Vec<(u32, TestResult)>,
}

#[derive(Debug, Clone, PartialEq)]
pub struct TraversalTrace<S: Scalar> {
    /// The steps, first to last.
    pub steps: Vec<TraceStep>,
    pub hit: Hit<S>,
    pub counters: WorkCounters,
}

impl<S: Scalar> TraversalTrace<S> {
    /// The steps and tests, counted.
    pub fn counted(&self) -> WorkCounters {
        let steps = |kind| self.steps.iter().filter(|step| step.kind == kind).count() as u64;
        let all = || self.steps.iter().flat_map(|step| &step.tests);
        let spared = all().filter(|(_, outcome)| *outcome == TestResult::Spared).count() as u64;
        let empty = steps(CellKind::Empty);
        WorkCounters {
            intersection_tests: all().count() as u64 - spared,
            traversal_steps: self.steps.len() as u64,
            elementary_steps: steps(CellKind::Leaf) + empty,
            empty_elementary_steps: empty,
            tests_saved: spared,
        }
    }
}

/// A counted closest-hit query that remembers.
pub(crate) struct Recorder<'a, S: Scalar, P: PrimSet<S>, M> {
    pub(crate) query: ClosestHit<'a, S, P, WorkCounters, M>,
    pub(crate) steps: Vec<TraceStep>,
}

impl<S: Scalar, P: PrimSet<S>, M: Mailbox> Recorder<'_, S, P, M> {
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
