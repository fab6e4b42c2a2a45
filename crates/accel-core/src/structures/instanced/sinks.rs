//! The sinks between the levels: the upper one hands a ray to the objects whose copies it meets, the lower one
//! hands their primitives to the query.

use std::ops::ControlFlow;

use super::{Copy, Instanced};
use crate::geometry::ray::Ray;
use crate::geometry::scalar::Scalar;
use crate::query::sink::Sink;
use crate::structure::Structure;

/// Copies that a ray was handed to lately, so that it is not handed to them once more by the next cell.
const REMEMBERED: usize = 8;

/// What the upper level sees of a query.
pub(super) struct Upper<'a, S: Scalar, T, K> {
    pub structure: &'a Instanced<S, T>,
    pub ray: &'a Ray<S>,
    pub query: &'a mut K,
    visited: [u32; REMEMBERED],
}

impl<'a, S: Scalar, T: Structure<S>, K: Sink<S>> Upper<'a, S, T, K> {
    pub fn new(structure: &'a Instanced<S, T>, ray: &'a Ray<S>, query: &'a mut K) -> Self {
        Self { structure, ray, query, visited: [u32::MAX; REMEMBERED] }
    }

    #[inline(always)]
    fn enter(&mut self, index: u32) -> ControlFlow<()> {
        if T::DUPLICATES {
            let slot = &mut self.visited[index as usize % REMEMBERED];
            if *slot == index {
                return ControlFlow::Continue(());
            }
            *slot = index;
        }
        let copy = &self.structure.copies[index as usize];
        let Ray { origin, direction, t_min, .. } = *self.ray;
        if copy.bounds.clip(origin, direction, t_min, self.query.t_max()).is_none() {
            return ControlFlow::Continue(());
        }
        let object = &self.structure.objects[copy.object as usize];
        let mut query =
            Lower { query: &mut *self.query, members: &object.members, copy, is_over: false };
        match copy.carried(self.ray) {
            Some(ray) => object.structure.walk(&ray, &mut query),
            // too long or too short there: nothing is left out
            None => {
                let _ = (0..object.count).try_for_each(|own| query.test(&[own]));
            }
        }
        if query.is_over { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }
}

impl<S: Scalar, T: Structure<S>, K: Sink<S>> Sink<S> for Upper<'_, S, T, K> {
    const COUNTING: bool = K::COUNTING;

    #[inline(always)]
    fn t_max(&self) -> S {
        self.query.t_max()
    }

    #[inline(always)]
    fn test(&mut self, indices: &[u32]) -> ControlFlow<()> {
        indices.iter().try_for_each(|&index| self.enter(index))
    }

    #[inline(always)]
    fn is_any_hit(&self) -> bool {
        self.query.is_any_hit()
    }

    #[inline(always)]
    fn elementary_step(&mut self, _: bool) {
        self.query.inner_step();
    }

    #[inline(always)]
    fn inner_step(&mut self) {
        self.query.inner_step();
    }
}

/// What the structure of an object sees of a query.
struct Lower<'a, S: Scalar, K> {
    query: &'a mut K,
    members: &'a super::object::Members,
    copy: &'a Copy<S>,
    is_over: bool,
}

/// Ids that are handed on at once.
const AT_ONCE: usize = 16;

impl<S: Scalar, K: Sink<S>> Lower<'_, S, K> {
    #[inline(always)]
    fn hand_on(
        &mut self,
        ids: &[u32],
        mut to: impl FnMut(&mut K, &[u32]) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        let mut room = [0; AT_ONCE];
        for part in ids.chunks(AT_ONCE) {
            for (place, &own) in room.iter_mut().zip(part) {
                *place = self.members.id(self.copy.first, own);
            }
            let went_on = to(&mut *self.query, &room[..part.len()]);
            self.is_over = went_on.is_break();
            went_on?;
        }
        ControlFlow::Continue(())
    }
}

impl<S: Scalar, K: Sink<S>> Sink<S> for Lower<'_, S, K> {
    const COUNTING: bool = K::COUNTING;

    #[inline(always)]
    fn t_max(&self) -> S {
        self.query.t_max()
    }

    #[inline(always)]
    fn test(&mut self, ids: &[u32]) -> ControlFlow<()> {
        self.hand_on(ids, |query, ids| query.test(ids))
    }

    #[inline(always)]
    fn test_in_cell(&mut self, ids: &[u32], t_exit: S) -> ControlFlow<()> {
        self.hand_on(ids, |query, ids| query.test_in_cell(ids, t_exit))
    }

    #[inline(always)]
    fn is_any_hit(&self) -> bool {
        self.query.is_any_hit()
    }

    #[inline(always)]
    fn elementary_step(&mut self, empty: bool) {
        self.query.elementary_step(empty);
    }

    #[inline(always)]
    fn inner_step(&mut self) {
        self.query.inner_step();
    }
}
