//! A sink as an object.

use std::ops::ControlFlow;

use crate::geometry::scalar::Scalar;
use crate::query::sink::Sink;

/// A sink behind dynamic calls. Counting passes traverse with this one type, so that a traversal is
/// compiled once for all queries and all kinds of primitives that are not timed. Steps are reported
/// with `COUNTED` alone.
pub struct ErasedSink<'a, S: Scalar, const COUNTED: bool = true>(&'a mut dyn SinkObject<S>);

impl<'a, S: Scalar, const COUNTED: bool> ErasedSink<'a, S, COUNTED> {
    /// Hides the type of a sink.
    pub fn new<K: Sink<S>>(sink: &'a mut K) -> Self {
        Self(sink)
    }
}

/// The methods of [`Sink`] as an object has them.
trait SinkObject<S: Scalar> {
    fn t_max_of(&self) -> S;
    fn is_any_hit_of(&self) -> bool;
    fn test_of(&mut self, ids: &[u32], t_exit: Option<S>) -> ControlFlow<()>;
    fn elementary_step_of(&mut self, empty: bool);
    fn inner_step_of(&mut self);
}

impl<S: Scalar, K: Sink<S>> SinkObject<S> for K {
    fn t_max_of(&self) -> S {
        self.t_max()
    }

    fn is_any_hit_of(&self) -> bool {
        self.is_any_hit()
    }

    fn test_of(&mut self, ids: &[u32], t_exit: Option<S>) -> ControlFlow<()> {
        match t_exit {
            Some(t_exit) => self.test_in_cell(ids, t_exit),
            None => self.test(ids),
        }
    }

    fn elementary_step_of(&mut self, empty: bool) {
        self.elementary_step(empty);
    }

    fn inner_step_of(&mut self) {
        self.inner_step();
    }
}

impl<S: Scalar, const COUNTED: bool> Sink<S> for ErasedSink<'_, S, COUNTED> {
    const COUNTING: bool = COUNTED;

    fn t_max(&self) -> S {
        self.0.t_max_of()
    }

    fn is_any_hit(&self) -> bool {
        self.0.is_any_hit_of()
    }

    fn test(&mut self, ids: &[u32]) -> ControlFlow<()> {
        self.0.test_of(ids, None)
    }

    fn test_in_cell(&mut self, ids: &[u32], t_exit: S) -> ControlFlow<()> {
        self.0.test_of(ids, Some(t_exit))
    }

    fn elementary_step(&mut self, empty: bool) {
        if COUNTED {
            self.0.elementary_step_of(empty);
        }
    }

    fn inner_step(&mut self) {
        if COUNTED {
            self.0.inner_step_of();
        }
    }
}
