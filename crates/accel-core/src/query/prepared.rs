//! The rays of a batch prepared eight at a time, in lanes; each then goes to its end before the
//! next one begins, or all eight go together where they run alike and the structure has a way for
//! that.
//!
//! What a structure and a triangle test derive from a ray is a quarter of the instructions of a
//! closest hit in a wide BVH, and a third of an occlusion's, and it is waited for: nothing can be
//! fetched before. In lanes it is the work of one ray for eight, and done when a ray begins. Steps,
//! answers and counters of rays that go alone are those of [`Structure::traverse`]. To have several
//! prepared rays in flight besides was a loss (two 0.85 to 1.0, four 0.77 to 0.88 of one after the
//! other).

use std::ops::Range;

use crate::geometry::far_ray::{self, Parameters};
use crate::geometry::ray_lanes::{LANES, RayLanes};
use crate::geometry::scalar::Scalar;
use crate::primitives::PrimSet;
use crate::query::batch::{Batch, BatchDriver, PlainStructure, RayByRay, drive};
use crate::query::counters::Counters;
use crate::query::sink::{Answer, Sink};
use crate::structure::Structure;

/// A structure that derives what it needs of eight rays at once.
pub(crate) trait LaneStructure<S: Scalar>: Structure<S> {
    type Eight;
    /// The shared part of the eight states.
    type Packet;

    /// Prepares rays that are near ([`far_ray::are_near`]).
    fn prepare(&self, rays: &RayLanes<S>) -> Self::Eight;
    /// The packet of eight coherent rays; `None` if their traversals diverge.
    fn packet(&self, eight: &Self::Eight) -> Option<Self::Packet>;
    /// Answers the queries of eight rays, one a ray in their order, together.
    fn trace_packet<K: Sink<S>>(&self, eight: &Self::Eight, packet: &Self::Packet, sinks: &mut [K]);
    /// [`Structure::traverse`] for one of them.
    fn trace_prepared<K: Sink<S>>(&self, eight: &Self::Eight, lane: usize, sink: &mut K);
}

/// One prepared ray after the other.
pub(crate) struct SequentialDriver;

impl<S: Scalar, T: LaneStructure<S>> BatchDriver<S, T> for SequentialDriver {
    #[inline(always)]
    fn all<P: PrimSet<S>, C: Counters, A: Answer<S>>(
        structure: &T,
        reach: S,
        batch: &mut Batch<'_, '_, S, P, C, A>,
        places: Range<usize>,
    ) {
        let (prims, alone) = (batch.prims, &PlainStructure(structure));
        let (eights, rest) = batch.rays[places.clone()].as_chunks();
        // of a packet; nothing is allocated where there is none
        let mut sinks = Vec::new();
        for (number, rays) in eights.iter().enumerate() {
            let first = places.start + number * rays.len();
            let lanes = RayLanes::of(rays);
            if !far_ray::are_near(&lanes, reach) {
                let places = first..first + rays.len();
                drive::<RayByRay, _, _, _, _, _>(alone, reach, batch, places);
                continue;
            }
            let setups = prims.setups(rays, &lanes);
            let eight = structure.prepare(&lanes);
            if let Some(packet) = structure.packet(&eight) {
                sinks.clear();
                sinks.reserve(LANES);
                for (lane, ray) in rays.iter().enumerate() {
                    sinks.push(batch.query(ray, setups(lane)));
                }
                structure.trace_packet(&eight, &packet, &mut sinks);
                for (lane, sink) in sinks.iter().enumerate() {
                    batch.keep(first + lane, sink, Parameters::SAME);
                }
                continue;
            }
            for (lane, ray) in rays.iter().enumerate() {
                let mut sink = batch.query(ray, setups(lane));
                structure.trace_prepared(&eight, lane, &mut sink);
                batch.keep(first + lane, &sink, Parameters::SAME);
            }
        }
        let rest = places.end - rest.len()..places.end;
        drive::<RayByRay, _, _, _, _, _>(alone, reach, batch, rest);
    }
}
