//! Eight rays of a batch: set up at once, and on their way one by one or, where they run alike,
//! together.

use crate::geometry::ray_lanes::{LANES, RayLanes};
use crate::geometry::scalar::Scalar;
use crate::query::prepared::LaneStructure;
use crate::query::sink::Sink;
use crate::structure::Batches;
use crate::structures::obvhs::box_ray::{BoxParameters, BoxRayLanes};
use crate::structures::wide_bvh::WideBvh;
use crate::structures::wide_bvh::node_ray_lanes::NodeRayLanes;
use crate::structures::wide_bvh::packet::Packet;
use crate::structures::wide_bvh::traversal::State;

/// Data of eight rays that node tests need.
pub struct EightRays<S: Scalar> {
    rays: NodeRayLanes,
    parameters: [BoxParameters<S>; LANES],
    /// Inputs from which `rays` was derived.
    origin: [[f32; LANES]; 3],
    direction: [[f32; LANES]; 3],
}

impl<S: Scalar> LaneStructure<S> for WideBvh<S> {
    type Eight = EightRays<S>;
    type Packet = Packet;

    #[inline(always)]
    fn prepare(&self, rays: &RayLanes<S>) -> EightRays<S> {
        let BoxRayLanes { origin, direction, parameters } = self.setup.ray_lanes(rays);
        let rays = NodeRayLanes::of(&origin, &direction, self.is_exact);
        EightRays { rays, parameters, origin, direction }
    }

    #[inline(always)]
    fn begin_prepared(&self, eight: &EightRays<S>, lane: usize, t_max: S) -> State<S> {
        self.at_root(eight.parameters[lane & (LANES - 1)], eight.rays.get(lane), t_max)
    }

    #[inline(always)]
    fn packet(&self, eight: &EightRays<S>) -> Option<Packet> {
        match self.batches {
            Batches::Packets => Packet::of(&eight.origin, &eight.direction, self.is_exact),
            _ => None,
        }
    }

    #[inline(always)]
    fn trace_packet<K: Sink<S>>(&self, eight: &EightRays<S>, packet: &Packet, sinks: &mut [K]) {
        packet.trace(self, &eight.rays, &eight.parameters, sinks);
    }
}
