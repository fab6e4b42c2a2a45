//! The rays of a batch prepared eight at a time, in lanes; each then goes to its end before the
//! next one begins, or all eight go together where they run alike ([`Packet`]).
//!
//! What the tree and a triangle test derive from a ray is a quarter of the instructions of a
//! closest hit in a wide BVH, and a third of an occlusion's, and it is waited for: nothing can be
//! fetched before. In lanes it is the work of one ray for eight, and done when a ray begins. Steps,
//! answers and counters of rays that go alone are those of
//! [`Structure::traverse`](crate::structure::Structure::traverse). To have several prepared rays in
//! flight besides was a loss (two 0.85 to 1.0, four 0.77 to 0.88 of one after the other).

use std::ops::Range;

use crate::bvh::WideBvh;
use crate::bvh::node::BoxParameters;
use crate::bvh::node_ray_lanes::{BoxRayLanes, NodeRayLanes};
use crate::bvh::packet::Packet;
use crate::bvh::traverse::runs_like_the_last;
use crate::geometry::far_ray::{self, Parameters};
use crate::geometry::ray_lanes::{LANES, RayLanes, lane_of};
use crate::geometry::scalar::Scalar;
use crate::primitives::PrimSet;
use crate::query::batch::{self, Batch, BatchDriver, PlainStructure, RayByRay, drive};
use crate::query::counters::Counters;
use crate::query::sink::{Answer, Sink};
use crate::structure::{Batches, RayBatch};

/// Data of eight rays that node tests need.
struct EightRays<S: Scalar> {
    rays: NodeRayLanes,
    parameters: [BoxParameters<S>; LANES],
    /// Inputs from which `rays` was derived.
    origin: [[f32; LANES]; 3],
    direction: [[f32; LANES]; 3],
}

impl<S: Scalar> EightRays<S> {
    /// Prepares rays that are near ([`far_ray::are_near`]).
    #[inline(always)]
    fn of(bvh: &WideBvh<S>, rays: &RayLanes<S>) -> Self {
        let BoxRayLanes { origin, direction, parameters } = bvh.setup.ray_lanes(rays);
        let rays = NodeRayLanes::of(&origin, &direction, bvh.is_exact);
        Self { rays, parameters, origin, direction }
    }

    /// Answers the query of one of them.
    #[inline(always)]
    fn trace<K: Sink<S>>(&self, bvh: &WideBvh<S>, lane: usize, sink: &mut K) {
        let lane = lane & (LANES - 1);
        let (ray, parameters) = (self.rays.get(lane), self.parameters[lane]);
        let end = parameters.bound(sink.t_max());
        let is_foreseen = runs_like_the_last(
            lane_of(&self.origin, lane).into(),
            lane_of(&self.direction, lane).into(),
        );
        let _ = bvh.traverse_from(bvh.root, ray, is_foreseen, parameters, end, sink);
    }
}

impl<S: Scalar> WideBvh<S> {
    /// [`Structure::answer_batch`](crate::structure::Structure::answer_batch).
    #[inline(always)]
    pub(super) fn answer_prepared<P: PrimSet<S>, C: Counters>(
        &self,
        prims: &P,
        batch: RayBatch<'_, S>,
    ) -> C {
        let unit = (self.batches == Batches::Packets).then(|| self.setup.unit());
        batch::answer::<SequentialDriver, C, _, _, _>(self, prims, batch, unit)
    }
}

/// One prepared ray after the other.
struct SequentialDriver;

impl<S: Scalar> BatchDriver<S, WideBvh<S>> for SequentialDriver {
    #[inline(always)]
    fn all<P: PrimSet<S>, C: Counters, A: Answer<S>>(
        structure: &WideBvh<S>,
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
            let eight = EightRays::of(structure, &lanes);
            if structure.batches == Batches::Packets
                && let Some(packet) =
                    Packet::of(&eight.origin, &eight.direction, structure.is_exact)
            {
                sinks.clear();
                sinks.reserve(LANES);
                for (lane, ray) in rays.iter().enumerate() {
                    sinks.push(batch.query(ray, setups(lane)));
                }
                packet.trace(structure, &eight.rays, &eight.parameters, &mut sinks);
                for (lane, sink) in sinks.iter().enumerate() {
                    batch.keep(first + lane, sink, Parameters::SAME);
                }
                continue;
            }
            for (lane, ray) in rays.iter().enumerate() {
                let mut sink = batch.query(ray, setups(lane));
                eight.trace(structure, lane, &mut sink);
                batch.keep(first + lane, &sink, Parameters::SAME);
            }
        }
        let rest = places.end - rest.len()..places.end;
        drive::<RayByRay, _, _, _, _, _>(alone, reach, batch, rest);
    }
}
