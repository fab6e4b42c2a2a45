//! Several rays of a batch in flight, each on its own: while one waits for memory, the
//! processor works on the others.
//!
//! A structure whose traversal can be interrupted is [`Resumable`]: one ray is driven to its end by
//! [`traverse`], a batch by [`InFlight`]. The steps are the same, and so are answers and
//! counters. In a batch, rays that are at the same kind of place take their steps one after the other, and
//! what kind that is decides no branch: one that waits for memory, and guesses wrong, would keep the others
//! waiting.

use std::ops::ControlFlow;

use crate::geometry::far_ray::{self, PlacedRay};
use crate::geometry::ray::Ray;
use crate::geometry::scalar::Scalar;
use crate::primitives::PrimSet;
use crate::query::batch::{Batch, Drive};
use crate::query::sink::Sink;
use crate::structure::Structure;

/// A structure whose traversal goes step by step: from inner places to others, and from a leaf on.
pub(crate) trait Resumable<S: Scalar>: Structure<S> {
    /// Where a ray is: what can be in registers.
    type State;
    /// The rest, whose content is of no use to the next ray.
    type Room: Default;

    /// Sets a ray on its way that ends at `t_max` at the latest.
    fn begin(&self, ray: &Ray<S>, t_max: S) -> Self::State;
    /// Whether a ray that has just begun meets nothing.
    fn is_nowhere(state: &Self::State) -> bool;
    /// Looks up what is where the ray has come to from a leaf, or has begun: apart from the way there, so that
    /// several rays' loads are begun before one is waited for.
    fn arrive(&self, state: &mut Self::State);
    /// Whether the ray is at a place that leads to others and holds no primitives.
    fn is_inner(state: &Self::State) -> bool;
    /// Whether the leaf that the ray is at holds nothing.
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
    /// Goes on from a leaf; false when nothing is left to visit. Of a ray that is over it may be asked, too;
    /// where that is then has no meaning.
    ///
    /// # Safety
    /// As for [`Resumable::descend`].
    unsafe fn leave<K: Sink<S>>(
        &self,
        state: &mut Self::State,
        room: &mut Self::Room,
        sink: &mut K,
    ) -> bool;
}

/// One ray.
#[inline(always)]
pub(crate) fn traverse<S: Scalar, T: Resumable<S>, K: Sink<S>>(
    structure: &T,
    ray: &Ray<S>,
    sink: &mut K,
) {
    let state = structure.begin(ray, sink.t_max());
    run(structure, state, sink);
}

/// A ray that has begun.
#[inline(always)]
pub(super) fn run<S: Scalar, T: Resumable<S>, K: Sink<S>>(
    structure: &T,
    mut state: T::State,
    sink: &mut K,
) {
    let mut goes_on = !T::is_nowhere(&state);
    let mut room = T::Room::default();
    while goes_on {
        structure.arrive(&mut state);
        while T::is_inner(&state) {
            // SAFETY: one room, one ray
            if !unsafe { structure.descend(&mut state, &mut room, sink) } {
                return;
            }
        }
        let is_empty = T::is_empty(&state);
        sink.elementary_step(is_empty);
        if !is_empty && structure.test(&state, sink).is_break() {
            return;
        }
        // SAFETY: one room, one ray
        goes_on = unsafe { structure.leave(&mut state, &mut room, sink) };
    }
}

/// Some of the lanes.
struct Chosen<const RAYS: usize> {
    lanes: [u8; RAYS],
    n: usize,
}

impl<const RAYS: usize> Chosen<RAYS> {
    #[inline(always)]
    fn new() -> Self {
        Self { lanes: [0; RAYS], n: 0 }
    }

    /// Adds a lane when it is wanted; lanes in order, each once.
    #[inline(always)]
    fn add(&mut self, lane: usize, is_wanted: bool) {
        self.lanes[self.n.min(RAYS - 1)] = lane as u8;
        self.n += usize::from(is_wanted);
    }

    #[inline(always)]
    fn iter(&self) -> impl Iterator<Item = usize> {
        self.lanes.iter().take(self.n).map(|&i| usize::from(i))
    }
}

/// A ray on its way.
struct Lane<State, Room, K> {
    state: State,
    room: Room,
    sink: K,
    /// In the batch.
    place: usize,
}

/// Answers rays that are near; the places of the others, which are few.
#[inline(always)]
fn all_near<
    'r,
    S: Scalar,
    P: PrimSet<S>,
    T: Resumable<S>,
    B: Batch<'r, S, P>,
    const RAYS: usize,
>(
    structure: &T,
    prims: &'r P,
    reach: S,
    batch: &mut B,
) -> Vec<usize> {
    const { assert!(RAYS <= u32::BITS as usize, "a bit for each lane") };
    let rays = batch.rays();
    let mut far = Vec::new();
    let mut waiting = 0..rays.len();
    let mut next_near = || {
        loop {
            let place = waiting.next()?;
            match far_ray::place(&rays[place], reach) {
                PlacedRay::Near => return Some(place),
                PlacedRay::Moved(..) | PlacedRay::Nowhere => far.push(place),
            }
        }
    };
    let mut lanes: Vec<Lane<T::State, T::Room, B::Sink>> = Vec::with_capacity(RAYS);
    // a bit for each lane whose query is over
    let mut over = 0u32;
    while lanes.len() < RAYS
        && let Some(place) = next_near()
    {
        let sink = batch.sink(&rays[place], prims.setup(&rays[place]));
        let state = structure.begin(&rays[place], sink.t_max());
        over |= u32::from(T::is_nowhere(&state)) << lanes.len();
        lanes.push(Lane { state, room: T::Room::default(), sink, place });
    }
    loop {
        // from the last: a lane that gets no other ray is replaced by one already looked at
        while over != 0 {
            let i = over.ilog2() as usize;
            let Some(place) = next_near() else {
                over ^= 1 << i;
                let lane = lanes.swap_remove(i);
                batch.keep(lane.place, &lane.sink);
                continue;
            };
            let lane = &mut lanes[i];
            batch.keep(lane.place, &lane.sink);
            lane.place = place;
            lane.sink = batch.sink(&rays[place], prims.setup(&rays[place]));
            lane.state = structure.begin(&rays[place], lane.sink.t_max());
            over ^= u32::from(!T::is_nowhere(&lane.state)) << i;
        }
        if lanes.is_empty() {
            return far;
        }
        let mut inner = Chosen::<RAYS>::new();
        for (i, lane) in lanes.iter_mut().enumerate() {
            structure.arrive(&mut lane.state);
            inner.add(i, T::is_inner(&lane.state));
        }
        while inner.n > 0 {
            let mut still = Chosen::new();
            for i in inner.iter() {
                let Lane { state, room, sink, .. } = &mut lanes[i];
                // SAFETY: a lane has one room, and one ray until that is over
                let goes_on = unsafe { structure.descend(state, room, sink) };
                over |= u32::from(!goes_on) << i;
                still.add(i, goes_on & T::is_inner(state));
            }
            inner = still;
        }
        let mut full = Chosen::<RAYS>::new();
        for (i, lane) in lanes.iter().enumerate() {
            full.add(i, !T::is_empty(&lane.state) & (over >> i & 1 == 0));
        }
        for i in full.iter() {
            let Lane { state, sink, .. } = &mut lanes[i];
            over |= u32::from(structure.test(state, sink).is_break()) << i;
        }
        for (i, Lane { state, room, sink, .. }) in lanes.iter_mut().enumerate() {
            // SAFETY: as above
            over |= u32::from(!unsafe { structure.leave(state, room, sink) }) << i;
        }
    }
}

/// So many rays in flight.
pub(crate) struct InFlight<const RAYS: usize>;

impl<S: Scalar, T: Resumable<S>, const RAYS: usize> Drive<S, T> for InFlight<RAYS> {
    #[inline(always)]
    fn all<'r, P: PrimSet<S>, B: Batch<'r, S, P>>(
        structure: &T,
        prims: &'r P,
        reach: S,
        batch: &mut B,
    ) {
        for place in all_near::<S, P, T, B, RAYS>(structure, prims, reach, batch) {
            batch.answer(structure, reach, place);
        }
    }
}
