//! Trace of one ray through a structure: the steps of the counted traversal, in their order.
//!
//! It is written down by a sink around the counted query, through the one
//! [`ErasedSink`](crate::query::sink::ErasedSink) that counting passes traverse with: the traversal
//! is that which is counted. A sink is not told where the ray is;
//! [`entered`](crate::query::entered) finds that.

mod recorder;

pub(crate) use recorder::Recorder;

use crate::geometry::ray::Hit;
use crate::geometry::scalar::Scalar;
use crate::query::cells::CellKind;
use crate::query::counters::WorkCounters;

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
