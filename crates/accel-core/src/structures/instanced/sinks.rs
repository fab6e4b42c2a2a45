//! The sinks between the levels: the upper one hands a ray to the objects whose copies it meets,
//! the lower one hands their primitives to the query. The query is an object to both, so that a
//! level's traversal is compiled once for all queries.

use std::ops::ControlFlow;

use super::object::{Copy, Members, Object};
use crate::geometry::ray::Ray;
use crate::geometry::scalar::Scalar;
use crate::query::sink::{ErasedSink, Sink, steps_of_query};
use crate::structure::Structure;

/// Copies that a ray was handed to lately, so that it is not handed to them once more by the next
/// cell.
const REMEMBERED: usize = 8;

/// The sink of the upper level: passes instances on to their objects.
pub(super) struct WorldSink<'a, 'q, S: Scalar, T, const COUNTED: bool> {
    copies: &'a [Copy<S>],
    objects: &'a [Object<T>],
    ray: &'a Ray<S>,
    query: ErasedSink<'q, S, COUNTED>,
    is_any_hit: bool,
    t_max: S,
    visited: [u32; REMEMBERED],
}

impl<'a, 'q, S: Scalar, T: Structure<S>, const COUNTED: bool> WorldSink<'a, 'q, S, T, COUNTED> {
    pub fn new(
        copies: &'a [Copy<S>],
        objects: &'a [Object<T>],
        ray: &'a Ray<S>,
        query: ErasedSink<'q, S, COUNTED>,
    ) -> Self {
        let (is_any_hit, t_max) = (query.is_any_hit(), query.t_max());
        Self { copies, objects, ray, query, is_any_hit, t_max, visited: [u32::MAX; REMEMBERED] }
    }

    #[inline]
    fn enter(&mut self, index: u32) -> ControlFlow<()> {
        if T::DUPLICATES {
            let slot = &mut self.visited[index as usize % REMEMBERED];
            if *slot == index {
                return ControlFlow::Continue(());
            }
            *slot = index;
        }
        let copy = &self.copies[index as usize];
        let Ray { origin, direction, t_min, .. } = *self.ray;
        if copy.bounds.clip(origin, direction, t_min, self.t_max).is_none() {
            return ControlFlow::Continue(());
        }
        let object = &self.objects[copy.object as usize];
        let mut query = ObjectSink {
            query: &mut self.query,
            members: &object.members,
            first: copy.first,
            is_any_hit: self.is_any_hit,
            t_max: self.t_max,
            is_over: false,
        };
        match copy.carried(self.ray) {
            Some(ray) => object.structure.traverse(&ray, &mut query),
            // too long or too short there: nothing is left out
            None => {
                let _ = (0..object.count).try_for_each(|own| query.test(&[own]));
            }
        }
        self.t_max = query.t_max;
        if query.is_over { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }
}

impl<S: Scalar, T: Structure<S>, const COUNTED: bool> Sink<S> for WorldSink<'_, '_, S, T, COUNTED> {
    const COUNTING: bool = COUNTED;

    #[inline(always)]
    fn t_max(&self) -> S {
        self.t_max
    }

    #[inline(always)]
    fn test(&mut self, indices: &[u32]) -> ControlFlow<()> {
        indices.iter().try_for_each(|&index| self.enter(index))
    }

    #[inline(always)]
    fn is_any_hit(&self) -> bool {
        self.is_any_hit
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

/// Ids that are handed on at once.
const AT_ONCE: usize = 16;

/// The sink of an object's structure: maps hits back to the world.
struct ObjectSink<'a, 'q, S: Scalar, const COUNTED: bool> {
    query: &'a mut ErasedSink<'q, S, COUNTED>,
    members: &'a Members,
    /// The id of the copy's first primitive.
    first: u32,
    is_any_hit: bool,
    t_max: S,
    is_over: bool,
}

impl<'q, S: Scalar, const COUNTED: bool> ObjectSink<'_, 'q, S, COUNTED> {
    #[inline]
    fn hand_on(
        &mut self,
        ids: &[u32],
        to: impl Fn(&mut ErasedSink<'q, S, COUNTED>, &[u32]) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        let mut room = [0; AT_ONCE];
        for part in ids.chunks(AT_ONCE) {
            for (place, &own) in room.iter_mut().zip(part) {
                *place = self.members.id(self.first, own);
            }
            let went_on = to(&mut *self.query, &room[..part.len()]);
            self.is_over = went_on.is_break();
            went_on?;
        }
        if !self.is_any_hit {
            self.t_max = self.query.t_max();
        }
        ControlFlow::Continue(())
    }
}

impl<S: Scalar, const COUNTED: bool> Sink<S> for ObjectSink<'_, '_, S, COUNTED> {
    const COUNTING: bool = COUNTED;
    steps_of_query!();

    #[inline(always)]
    fn t_max(&self) -> S {
        self.t_max
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
        self.is_any_hit
    }
}
