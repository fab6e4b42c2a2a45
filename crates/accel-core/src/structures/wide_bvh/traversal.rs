//! One ray's way through the tree: its setup and its steps.

use std::ops::ControlFlow;

use crate::geometry::ray::Ray;
use crate::geometry::scalar::Scalar;
use crate::memory::prefetch;
use crate::query::resumable::StepwiseStructure;
use crate::query::sink::Sink;
use crate::structures::obvhs::box_ray::{BoxParameters, BoxRay, Length};
use crate::structures::wide_bvh::WideBvh;
use crate::structures::wide_bvh::collapse::LEAF;
use crate::structures::wide_bvh::node::NodeRay;
use crate::structures::wide_bvh::stack::{Stack, StackStorage};

/// A ray's way through the tree.
pub struct State<S: Scalar> {
    parameters: BoxParameters<S>,
    ray: NodeRay,
    /// End of the query, as a parameter of `ray`.
    end: f32,
    at: u32,
    waiting: usize,
}

impl<S: Scalar> WideBvh<S> {
    #[inline(always)]
    pub(super) fn at_root(&self, parameters: BoxParameters<S>, ray: NodeRay, t_max: S) -> State<S> {
        State::at_node(parameters, ray, parameters.bound(t_max), self.root)
    }

    /// Begins to load a child.
    #[inline(always)]
    pub(super) fn prefetch(&self, child: u32) {
        match child & LEAF {
            0 => prefetch(&self.nodes[child as usize]),
            _ => self.lists.prefetch(child & !LEAF),
        }
    }
}

impl<S: Scalar> State<S> {
    /// A ray that goes on from a node, as if nothing waited.
    #[inline(always)]
    pub(super) fn at_node(parameters: BoxParameters<S>, ray: NodeRay, end: f32, at: u32) -> Self {
        Self { parameters, ray, end, at, waiting: 0 }
    }
}

impl<S: Scalar> StepwiseStructure<S> for WideBvh<S> {
    type State = State<S>;
    type Room = StackStorage;

    #[inline(always)]
    fn begin(&self, ray: &Ray<S>, t_max: S) -> State<S> {
        let BoxRay { origin, direction, parameters } = self.setup.ray(ray, Length::Own);
        let is_exact = self.is_exact && !parameters.starts_earlier();
        let of_nodes = NodeRay::of(origin, direction, is_exact);
        #[cfg(feature = "compiled-tests")]
        let of_nodes = if self.is_plain { NodeRay::plain(origin, direction) } else { of_nodes };
        self.at_root(parameters, of_nodes, t_max)
    }

    #[inline(always)]
    fn misses(_: &State<S>) -> bool {
        false
    }

    #[inline(always)]
    fn arrive(&self, _: &mut State<S>) {}

    #[inline(always)]
    fn is_inner(state: &State<S>) -> bool {
        state.at & LEAF == 0
    }

    #[inline(always)]
    fn is_empty(_: &State<S>) -> bool {
        false
    }

    #[inline(always)]
    unsafe fn descend<K: Sink<S>>(
        &self,
        state: &mut State<S>,
        room: &mut StackStorage,
        sink: &mut K,
    ) -> bool {
        sink.inner_step();
        let node = &self.nodes[state.at as usize];
        // SAFETY: the ray has been in this room since it began, and nothing waited then
        let mut stack = unsafe { Stack::new(room, &mut state.waiting) };
        let name = |child: usize| node.children[child];
        match stack.descend(node, &state.ray, state.end, sink.is_any_hit(), name) {
            Some(next) => {
                state.at = next;
                true
            }
            None => false,
        }
    }

    #[inline(always)]
    fn test<K: Sink<S>>(&self, state: &State<S>, sink: &mut K) -> ControlFlow<()> {
        self.lists.test(state.at & !LEAF, sink)
    }

    #[inline(always)]
    unsafe fn leave<K: Sink<S>>(
        &self,
        state: &mut State<S>,
        room: &mut StackStorage,
        sink: &mut K,
    ) -> bool {
        if !sink.is_any_hit() {
            state.end = state.parameters.bound(sink.t_max());
        }
        // SAFETY: as in `descend`
        let next = unsafe { Stack::new(room, &mut state.waiting) }.pop(state.end);
        if let Some(next) = next {
            state.at = next;
        }
        next.is_some()
    }
}
