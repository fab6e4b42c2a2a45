//! Rays of a batch side by side: each in a lane of vectors, all taking a step at once; a lane whose
//! ray is over gets the next ray of the batch.
//!
//! One ray is a chain in which each step waits for the one before. In lanes a step is a few
//! instructions for each ray, and while one waits for memory the others need not. Answers are those
//! of one ray after the other, to the same bits, as are the steps.

use std::ops::{ControlFlow, Range};

use wide::u32x8;

use crate::geometry::far_ray::{self, Parameters};
use crate::geometry::lanes::take_lowest;
use crate::geometry::ray_lanes::{LANES, RayLanes};
use crate::geometry::scalar::Scalar;
use crate::primitives::PrimSet;
use crate::query::batch::{Batch, BatchDriver, RayByRay, Traverse, drive};
use crate::query::counters::Counters;
use crate::query::sink::{Answer, Sink};

/// Groups of eight lanes. Four, against two, are worth 4% for diffuse and shadow rays, where memory
/// is waited for.
pub(crate) const EIGHTS: usize = 4;

/// Rays side by side.
pub(crate) const RAYS: usize = EIGHTS * LANES;

/// A bit for each lane.
const ALL: u32 = u32::MAX >> (u32::BITS as usize - RAYS);

/// A structure in which a step is the same few instructions whatever the ray.
pub(crate) trait LaneTraversal<S: Scalar> {
    /// State that the structure derives from eight rays.
    type Eight;
    /// Traversal state of [`RAYS`] rays.
    type State;

    /// For rays that go alone.
    fn alone(&self) -> impl Traverse<S>;
    /// Prepares rays that are near ([`far_ray::are_near`]).
    fn prepare(&self, rays: &RayLanes<S>) -> Self::Eight;
    /// A bit for each of them that meets the structure.
    fn meeting(eight: &Self::Eight) -> u32;
    /// State without rays; every lane still refers to a valid place in the structure.
    fn idle() -> Self::State;
    /// Sets a prepared ray that meets the structure on its way in a lane.
    fn begin(&self, state: &mut Self::State, lane: usize, eight: &Self::Eight, ray: usize);
    /// The list of primitives where each lane has come to, 0 for an empty one.
    fn arrive(&self, state: &mut Self::State) -> [u32; RAYS];
    /// Begins to load a list.
    fn prefetch(&self, list: u32);
    /// Tests the primitives of a list; `Break` when the query is over.
    fn test<K: Sink<S>>(&self, list: u32, sink: &mut K) -> ControlFlow<()>;
    /// Goes on; a bit for each lane in which nothing is left to visit. All lanes are somewhere in
    /// the structure after it.
    fn leave(&self, state: &mut Self::State, t_max: &[S; RAYS]) -> u32;
}

/// [`RAYS`] rays side by side.
pub(crate) struct LaneDriver;

impl<S: Scalar, T: LaneTraversal<S>> BatchDriver<S, T> for LaneDriver {
    #[inline(always)]
    fn all<P: PrimSet<S>, C: Counters, A: Answer<S>>(
        structure: &T,
        reach: S,
        batch: &mut Batch<'_, '_, S, P, C, A>,
        all: Range<usize>,
    ) {
        let prims = batch.prims;
        let (eights, rest) = batch.rays[all.clone()].as_chunks::<LANES>();
        let mut state = T::idle();
        let mut sinks = Vec::with_capacity(RAYS);
        let (mut places, mut t_max) = ([0; RAYS], [S::ZERO; RAYS]);
        let mut free = ALL;
        for number in 0..=eights.len() {
            // once more when none are left, until all that are on their way have come to an end
            let is_over = number == eights.len();
            let Some(rays) = eights.get(number).or(eights.last()) else { break };
            let first = all.start + number * LANES;
            let lanes = RayLanes::of(rays);
            if !is_over && !far_ray::are_near(&lanes, reach) {
                let alone = first..first + LANES;
                drive::<RayByRay, _, _, _, _, _>(&structure.alone(), reach, batch, alone);
                continue;
            }
            let setups = prims.setups(rays, &lanes);
            let eight = structure.prepare(&lanes);
            let mut waiting = if is_over { 0 } else { u32::MAX >> (u32::BITS as usize - LANES) };
            loop {
                while free != 0 && waiting != 0 {
                    let from = take_lowest(&mut waiting);
                    let sink = batch.query(&rays[from], setups(from));
                    if T::meeting(&eight) >> from & 1 == 0 {
                        batch.keep(first + from, &sink, Parameters::SAME);
                        continue;
                    }
                    let lane = take_lowest(&mut free);
                    structure.begin(&mut state, lane, &eight, from);
                    places[lane] = first + from;
                    t_max[lane] = sink.t_max();
                    // lanes are taken in their order until all have had a ray
                    match sinks.get_mut(lane) {
                        Some(last) => *last = sink,
                        None => sinks.push(sink),
                    }
                }
                if free == ALL || waiting == 0 && !is_over {
                    break;
                }
                let lists = structure.arrive(&mut state);
                let full = full(&lists) & !free;
                let mut soon = full;
                while soon != 0 {
                    structure.prefetch(lists[take_lowest(&mut soon)]);
                }
                let (mut now, mut over) = (full, 0);
                while now != 0 {
                    let lane = take_lowest(&mut now);
                    let sink = &mut sinks[lane];
                    over |= u32::from(structure.test(lists[lane], sink).is_break()) << lane;
                    t_max[lane] = sink.t_max();
                }
                over = (over | structure.leave(&mut state, &t_max)) & !free;
                free |= over;
                while over != 0 {
                    let lane = take_lowest(&mut over);
                    batch.keep(places[lane], &sinks[lane], Parameters::SAME);
                }
            }
        }
        let rest = all.end - rest.len()..all.end;
        drive::<RayByRay, _, _, _, _, _>(&structure.alone(), reach, batch, rest);
    }
}

/// A bit for each list that is not empty.
#[inline(always)]
fn full(lists: &[u32; RAYS]) -> u32 {
    let (eights, _) = lists.as_chunks::<LANES>();
    let mut empty = 0;
    for (number, eight) in eights.iter().enumerate() {
        empty |= u32x8::new(*eight).simd_eq(u32x8::ZERO).to_bitmask() << (number * LANES);
    }
    !empty & ALL
}
