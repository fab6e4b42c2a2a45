//! Traversals that go step by step, from inner places to leaves and on.
//!
//! A structure whose traversal can be interrupted is [`StepwiseStructure`]: one ray is driven to
//! its end by [`traverse`], and one that was prepared with others (`prepared.rs`) by [`run`]. The
//! steps are the same, and so are answers and counters.

use std::ops::ControlFlow;

use crate::geometry::ray::Ray;
use crate::geometry::scalar::Scalar;
use crate::query::sink::Sink;
use crate::structure::Structure;

/// A structure whose traversal goes step by step: from inner places to others, and from a leaf on.
pub(crate) trait StepwiseStructure<S: Scalar>: Structure<S> {
    /// The part of the traversal state that fits into registers.
    type State;
    /// The rest of the state; its content need not be kept for the next ray.
    type Room: Default;

    /// Sets a ray on its way that ends at `t_max` at the latest.
    fn begin(&self, ray: &Ray<S>, t_max: S) -> Self::State;
    /// Returns whether a ray that has just begun meets nothing.
    fn misses(state: &Self::State) -> bool;
    /// Looks up what is where the ray has come to from a leaf, or has begun.
    fn arrive(&self, state: &mut Self::State);
    /// Returns whether the ray is at a place that leads to others and holds no primitives.
    fn is_inner(state: &Self::State) -> bool;
    /// Returns whether the leaf that the ray is at holds nothing.
    fn is_empty(state: &Self::State) -> bool;
    /// Goes on from an inner place; false when nothing is left to visit.
    ///
    /// # Safety
    /// All steps of a ray since it began were in the same room, and no other ray's among them.
    unsafe fn descend<K: Sink<S>>(
        &self,
        state: &mut Self::State,
        room: &mut Self::Room,
        sink: &mut K,
    ) -> bool;
    /// Tests the primitives of the leaf that the ray is at; `Break` when the query is over.
    fn test<K: Sink<S>>(&self, state: &Self::State, sink: &mut K) -> ControlFlow<()>;
    /// Goes on from a leaf; false when nothing is left to visit.
    ///
    /// # Safety
    /// As for [`StepwiseStructure::descend`].
    unsafe fn leave<K: Sink<S>>(
        &self,
        state: &mut Self::State,
        room: &mut Self::Room,
        sink: &mut K,
    ) -> bool;
}

#[inline(always)]
pub(crate) fn traverse<S: Scalar, T: StepwiseStructure<S>, K: Sink<S>>(
    structure: &T,
    ray: &Ray<S>,
    sink: &mut K,
) {
    let state = structure.begin(ray, sink.t_max());
    let _ = run(structure, state, sink);
}

/// A ray that has begun; `Break` when the query is over before all is visited.
#[inline(always)]
pub(crate) fn run<S: Scalar, T: StepwiseStructure<S>, K: Sink<S>>(
    structure: &T,
    mut state: T::State,
    sink: &mut K,
) -> ControlFlow<()> {
    let mut goes_on = !T::misses(&state);
    let mut room = T::Room::default();
    while goes_on {
        structure.arrive(&mut state);
        while T::is_inner(&state) {
            // SAFETY: one room, one ray
            if !unsafe { structure.descend(&mut state, &mut room, sink) } {
                return ControlFlow::Continue(());
            }
        }
        let is_empty = T::is_empty(&state);
        sink.elementary_step(is_empty);
        if !is_empty {
            structure.test(&state, sink)?;
        }
        // SAFETY: one room, one ray
        goes_on = unsafe { structure.leave(&mut state, &mut room, sink) };
    }
    ControlFlow::Continue(())
}
