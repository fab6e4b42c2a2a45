//! Several rays of a batch on their way at once, each on its own: while one waits for memory, the
//! processor works on the others.
//!
//! A structure whose traversal can be interrupted is [`Resumable`]: one ray is driven to its end by
//! [`walk`], a batch by [`closest`] and [`occlusions`]. The steps are the same, and so are answers and
//! counters.

use std::ops::ControlFlow;

use crate::geometry::far_ray::{self, Place};
use crate::geometry::ray::{Hit, Ray};
use crate::geometry::scalar::Scalar;
use crate::primitives::PrimSet;
use crate::query::counters::NoCounters;
use crate::query::mailbox::NoMailbox;
use crate::query::sink::{AnyHit, ClosestHit, Sink};
use crate::query::tracer::nearby;
use crate::structure::Structure;

/// A structure whose traversal goes step by step.
pub(crate) trait Resumable<S: Scalar>: Structure<S> {
    /// Where a ray is: what can be in registers.
    type State;
    /// The rest, whose content is of no use to the next ray.
    type Room: Default;

    /// Sets a ray on its way that ends at `t_max` at the latest.
    fn begin(&self, ray: &Ray<S>, t_max: S) -> Self::State;
    /// Visits a node or a leaf; `Break` when nothing is left to visit, or the query is over.
    ///
    /// # Safety
    /// All steps of a ray since it began were in the same room, and no other ray's among them.
    unsafe fn next<K: Sink<S>>(
        &self,
        state: &mut Self::State,
        room: &mut Self::Room,
        sink: &mut K,
    ) -> ControlFlow<()>;
}

/// One ray.
#[inline(always)]
pub(crate) fn walk<S: Scalar, T: Resumable<S>, K: Sink<S>>(
    structure: &T,
    ray: &Ray<S>,
    sink: &mut K,
) {
    let mut state = structure.begin(ray, sink.t_max());
    let mut room = T::Room::default();
    // SAFETY: one room, one ray
    while unsafe { structure.next(&mut state, &mut room, sink) }.is_continue() {}
}

/// A ray on its way.
struct Lane<State, Room, K> {
    state: State,
    room: Room,
    sink: K,
    /// In the batch.
    place: usize,
}

/// Answers rays that are near; calls `far` with the places of the others, which are few.
#[inline(always)]
fn all<'r, S: Scalar, T: Resumable<S>, K: Sink<S>, const RAYS: usize>(
    structure: &T,
    rays: &'r [Ray<S>],
    reach: S,
    sink_of: impl Fn(&'r Ray<S>) -> K,
    mut finish: impl FnMut(usize, K),
    mut far: impl FnMut(usize),
) {
    let mut waiting = 0..rays.len();
    let mut next_near = || {
        loop {
            let place = waiting.next()?;
            match far_ray::place(&rays[place], reach) {
                Place::Near => return Some(place),
                Place::Moved(..) | Place::Nowhere => far(place),
            }
        }
    };
    let mut lanes: Vec<Lane<T::State, T::Room, K>> = Vec::with_capacity(RAYS);
    while lanes.len() < RAYS
        && let Some(place) = next_near()
    {
        let sink = sink_of(&rays[place]);
        let state = structure.begin(&rays[place], sink.t_max());
        lanes.push(Lane { state, room: T::Room::default(), sink, place });
    }
    while !lanes.is_empty() {
        let mut i = 0;
        while let Some(lane) = lanes.get_mut(i) {
            // SAFETY: a lane has one room, and one ray until that is over
            let next = unsafe { structure.next(&mut lane.state, &mut lane.room, &mut lane.sink) };
            if next.is_break() {
                let Some(place) = next_near() else {
                    let lane = lanes.swap_remove(i);
                    finish(lane.place, lane.sink);
                    continue;
                };
                let sink = std::mem::replace(&mut lane.sink, sink_of(&rays[place]));
                finish(lane.place, sink);
                lane.place = place;
                lane.state = structure.begin(&rays[place], lane.sink.t_max());
            }
            i += 1;
        }
    }
}

/// Closest hits of a batch, `RAYS` on their way at once.
#[inline(never)]
pub(crate) fn closest<S: Scalar, P: PrimSet<S>, T: Resumable<S>, const RAYS: usize>(
    structure: &T,
    prims: &P,
    rays: &[Ray<S>],
    reach: S,
    hits: &mut [Hit<S>],
) {
    let mut far = Vec::new();
    all::<S, T, _, RAYS>(
        structure,
        rays,
        reach,
        |ray| ClosestHit::<S, P, NoCounters>::new(prims, ray),
        |place, sink| {
            let found = sink.finish().0;
            hits[place] =
                if found.is_hit() { found } else { Hit { t: rays[place].t_max, ..Hit::NONE } };
        },
        |place| far.push(place),
    );
    for place in far {
        let (rays, hits) = (&rays[place..=place], &mut hits[place..=place]);
        nearby::closest(reach, rays, hits, NoMailbox, |ray, _| {
            let mut sink = ClosestHit::<S, P, NoCounters>::new(prims, ray);
            structure.walk(ray, &mut sink);
            sink.finish().0
        });
    }
}

/// [`closest`] for occlusion by opaque primitives.
#[inline(never)]
pub(crate) fn occlusions<S: Scalar, P: PrimSet<S>, T: Resumable<S>, const RAYS: usize>(
    structure: &T,
    prims: &P,
    rays: &[Ray<S>],
    reach: S,
    blocked: &mut [bool],
) {
    let mut far = Vec::new();
    all::<S, T, _, RAYS>(
        structure,
        rays,
        reach,
        |ray| AnyHit::<S, P, NoCounters>::new(prims, ray),
        |place, sink| blocked[place] = sink.finish().0,
        |place| far.push(place),
    );
    for place in far {
        blocked[place] = nearby::near(reach, &rays[place], false, |ray, _| {
            let mut sink = AnyHit::<S, P, NoCounters>::new(prims, ray);
            structure.walk(ray, &mut sink);
            sink.finish().0
        });
    }
}
