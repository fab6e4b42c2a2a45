//! Eight rays that run alike go through the tree together: one ray stands for all of them at nodes.
//!
//! Papers: I. Wald, P. Slusallek, C. Benthin, M. Wagner, "Interactive Rendering with Coherent Ray
//! Tracing", EG 2001 (packets); I. Wald, S. Boulos, P. Shirley, "Ray Tracing Deformable Scenes
//! using Dynamic Bounding Volume Hierarchies", TOG 26(1), 2007 (intervals over a packet's rays
//! against boxes); C. Benthin, I. Wald, S. Woop, M. Ernst, W. Mark, "Combining Single and
//! Packet-Ray Tracing for Arbitrary Ray Distributions on the Intel MIC Architecture", TVCG 18(9),
//! 2012 (rays go on alone where few are left). Rays in no order are put into one first
//! (`ray_order.rs`).
//!
//! Deviations: one test of eight boxes at a node with the interval, and one of eight rays with the
//! box of each child that it meets; at a list each ray that meets its box tests the blocks as it
//! would alone. A node that the rays visit together counts as one step of one of them.

use crate::bvh::WideBvh;
use crate::bvh::node::{BoxParameters, EPSILON, LEAF, LEAST_PART, NodeRay, WIDTH};
use crate::bvh::node_ray_lanes::NodeRayLanes;
use crate::bvh::slabs::LARGE;
use crate::bvh::traverse::Stack;
use crate::geometry::lanes::{Eight, Lanes, take_lowest};
use crate::geometry::ray_lanes::LANES;
use crate::geometry::scalar::Scalar;
use crate::query::ray_order::ALIKE;
use crate::query::sink::Sink;
use wide::f32x8;

/// So many rays that meet a node go on alone.
const FEW: u32 = 2;

/// Eight rays that run alike.
pub(super) struct Packet {
    /// Meets each box that any of them meets, and enters it no later.
    ray: NodeRay,
}

/// By lane, as long as one vector is.
#[repr(align(32))]
struct LaneEnds([f32; LANES]);

impl LaneEnds {
    fn last(&self) -> f32 {
        let [a, b, c, d, e, f, g, h] = self.0;
        a.max(b).max(c.max(d)).max(e.max(f).max(g.max(h)))
    }
}

impl Packet {
    /// Packet of rays as for [`NodeRay::of`], by axis and lane; `None` if their octants differ.
    #[inline(always)]
    pub(super) fn of(
        origin: &[[f32; LANES]; 3],
        direction: &[[f32; LANES]; 3],
        is_exact: bool,
    ) -> Option<Self> {
        let lanes = |v: &[[f32; LANES]; 3]| [f32x8::new(v[0]), f32x8::new(v[1]), f32x8::new(v[2])];
        let (o, d) = (lanes(origin), lanes(direction));
        // d is not -0
        let negative = [d[0].high_bits(), d[1].high_bits(), d[2].high_bits()];
        let is_apart = |signs: u32| signs != 0 && signs != (1 << LANES) - 1;
        if is_apart(negative[0]) || is_apart(negative[1]) || is_apart(negative[2]) {
            return None;
        }
        let [a, b, c] = [d[0].absolute(), d[1].absolute(), d[2].absolute()];
        // the last two are of no use
        let [r0, r1, r2, r3, r4, r5, r6, r7] = f32x8::transposed([o[0], o[1], o[2], a, b, c, a, b]);
        let least = r0.lesser(r1).lesser(r2.lesser(r3)).lesser(r4.lesser(r5).lesser(r6.lesser(r7)));
        let most =
            r0.greater(r1).greater(r2.greater(r3)).greater(r4.greater(r5).greater(r6.greater(r7)));
        let (least, most) = (least.to_array(), most.to_array());
        let (mut apart, mut far, mut longest, mut turned) = (0.0f32, 0.0f32, 0.0f32, 0.0f32);
        for k in 0..3 {
            apart = apart.max(most[k] - least[k]);
            far = far.max(least[k].abs()).max(most[k].abs());
            longest = longest.max(most[k + 3]);
            turned = turned.max(most[k + 3] - least[k + 3]);
        }
        if apart > ALIKE || turned > ALIKE * longest {
            return None;
        }
        // `SHIFT`, which is added to single rays, and the rounding of both (`proofs/packet.gappa`)
        let slack = (58.0 + 16.0 * far) * EPSILON;
        let (mut inverse, mut offset, mut octant) = ([[0.0; 3]; 2], [[0.0; 3]; 2], 0);
        for k in 0..3 {
            let is_negative = negative[k] != 0;
            octant |= u32::from(is_negative) << k;
            // where boxes are left nothing is added to single rays, but for the rounding of
            // products
            let is_tight = is_exact && least[k + 3] >= longest * LEAST_PART;
            let behind = if is_tight { 4.0 * far * EPSILON } else { slack };
            let (front, back) = if is_negative {
                (least[k] - slack, most[k] + behind)
            } else {
                (most[k] + slack, least[k] - behind)
            };
            let [least, most] = [most[k + 3], least[k + 3]].map(|d: f32| d.recip().min(LARGE));
            let sign = if is_negative { -1.0 } else { 1.0 };
            inverse[0][k] = sign * least;
            inverse[1][k] = sign * most;
            offset[0][k] = -(front * inverse[0][k]);
            // never -0: see `within`
            offset[1][k] = 0.0 - back * inverse[1][k];
        }
        Some(Self { ray: NodeRay::with(inverse, offset, octant) })
    }

    /// Answers the rays' queries in a tree whose root is a node.
    #[inline(always)]
    pub(super) fn trace<S: Scalar, K: Sink<S>>(
        &self,
        bvh: &WideBvh<S>,
        rays: &NodeRayLanes,
        parameters: &[BoxParameters<S>; LANES],
        sinks: &mut [K],
    ) {
        let mut ends = LaneEnds([f32::NEG_INFINITY; LANES]);
        for ((end, parameters), sink) in ends.0.iter_mut().zip(parameters).zip(&*sinks) {
            *end = parameters.bound(sink.t_max());
        }
        let is_any_hit = sinks[0].is_any_hit();
        let mut room = Stack::room();
        let mut stack = Stack::new(&mut room, true);
        let (mut end, mut at, mut first) = (ends.last(), bvh.root, 0);
        'nodes: loop {
            sinks[first].inner_step();
            let node = &bvh.nodes[at as usize];
            let name = |child: usize| {
                // most of what the packet meets, one of its rays meets: 5 to 15% faster on large
                // scenes
                bvh.prefetch(node.children[child]);
                at * WIDTH as u32 + child as u32
            };
            let mut next = stack.descend(node, &self.ray, end, is_any_hit, name);
            while let Some(place) = next {
                let (node, child) = (&bvh.nodes[place as usize / WIDTH], place as usize % WIDTH);
                let mut meeting = rays.meeting(node, child, &self.ray, &ends.0);
                let to = node.children[child];
                if meeting.count_ones() > FEW && to & LEAF == 0 {
                    (at, first) = (to, meeting.trailing_zeros() as usize & (LANES - 1));
                    continue 'nodes;
                }
                let is_met = meeting != 0;
                while meeting != 0 {
                    let lane = take_lowest(&mut meeting) & (LANES - 1);
                    let sink = &mut sinks[lane];
                    let flow = if to & LEAF == 0 {
                        let ray = rays.get(lane);
                        bvh.traverse_from(to, ray, true, parameters[lane], ends.0[lane], sink)
                    } else {
                        sink.elementary_step(false);
                        bvh.lists.test(to & !LEAF, sink)
                    };
                    if flow.is_break() {
                        ends.0[lane] = f32::NEG_INFINITY;
                    } else if !is_any_hit {
                        ends.0[lane] = parameters[lane].bound(sink.t_max());
                    }
                }
                if is_met {
                    end = ends.last();
                }
                next = stack.pop(end);
            }
            return;
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3A;

    use super::*;
    use crate::bvh::node::Node;
    use crate::geometry::ray_lanes::lane_of;
    use crate::structures::test_scenes::Random;

    type Columns = [[f32; LANES]; 3];

    /// Eight rays around one, as far apart as is drawn.
    fn around(random: &mut Random) -> (Columns, Columns) {
        let mut number = |scale: f64| ((random.unit() * 2.0 - 1.0) * scale) as f32;
        let [apart, turned] = [0; 2].map(|_| 10f32.powf(number(3.0) - 4.0));
        let is_far = number(1.0) > 0.8;
        let (mut origin, mut direction) = ([[0.0; LANES]; 3], [[0.0; LANES]; 3]);
        for k in 0..3 {
            let o = number(if is_far { 12.0 } else { 1.0 });
            let d = number(1.0) * if number(1.0) > 0.5 { 1e-4 } else { 1.0 };
            let is_along = number(1.0) > 0.8;
            for lane in 0..LANES {
                origin[k][lane] = o + number(1.0) * apart;
                direction[k][lane] = if is_along { 0.0 } else { d + number(1.0) * turned } + 0.0;
            }
        }
        (origin, direction)
    }

    /// Boxes near where the rays run, some of them flat.
    fn boxes(random: &mut Random, origin: &Columns, direction: &Columns) -> Node {
        let mut node = Node::empty();
        for child in 0..WIDTH {
            let t = random.unit() as f32 * 2.0;
            let size = 10f64.powf(-6.0 * random.unit());
            let (mut low, mut high) = ([0.0; 3], [0.0; 3]);
            for k in 0..3 {
                let at = origin[k][child] + t * direction[k][child];
                let mut off = || (random.unit() * 2.0 - 1.0) * size;
                let [a, b] = [at + off() as f32, at + off() as f32];
                (low[k], high[k]) = (a.min(b).max(-2.0), a.max(b).min(2.0));
                high[k] = if random.unit() < 0.1 { low[k] } else { high[k].max(low[k]) };
            }
            node.set_box(child, low, high);
        }
        node
    }

    #[test]
    fn a_packet_meets_what_any_of_its_rays_meets() {
        let mut random = Random(5);
        let (mut met, mut missed) = (0, 0);
        for _ in 0..60_000 {
            let (origin, direction) = around(&mut random);
            let is_exact = random.unit() < 0.5;
            let Some(packet) = Packet::of(&origin, &direction, is_exact) else { continue };
            let node = boxes(&mut random, &origin, &direction);
            let lanes = NodeRayLanes::of(&origin, &direction, is_exact);
            let end = random.unit() as f32 * 3.0;
            let (of_packet, entered) = packet.ray.test(&node, end);
            let entered = entered.to_array();
            for lane in 0..LANES {
                let of = |v: &Columns| Vec3A::from(lane_of(v, lane));
                let ray = NodeRay::of(of(&origin), of(&direction), is_exact);
                let (of_ray, enter) = ray.test(&node, end);
                for (child, enter) in enter.to_array().into_iter().enumerate() {
                    let is_met = of_ray >> child & 1;
                    let in_lanes = lanes.meeting(&node, child, &packet.ray, &[end; LANES]);
                    assert_eq!(in_lanes >> lane & 1, is_met, "{origin:?} {direction:?} {node:?}");
                    if is_met == 0 {
                        missed += of_packet >> child & 1;
                        continue;
                    }
                    met += 1;
                    assert_eq!(
                        of_packet >> child & 1,
                        1,
                        "{origin:?} {direction:?} {node:?} {child}"
                    );
                    assert!(entered[child] <= enter, "{origin:?} {direction:?} {node:?} {child}");
                }
            }
        }
        assert!(met > 200_000 && missed > 100_000, "{met} {missed}");
    }

    #[test]
    fn a_box_that_ends_at_minus_0_where_all_rays_begin_is_met() {
        let (origin, direction) = ([[0.0; LANES]; 3], [[1.0; LANES], [0.5; LANES], [0.5; LANES]]);
        let packet = Packet::of(&origin, &direction, true).unwrap();
        let lanes = NodeRayLanes::of(&origin, &direction, true);
        let mut node = Node::empty();
        node.set_box(2, [-1.0; 3], [-0.0, 1.0, 1.0]);
        assert_eq!(packet.ray.test(&node, 1.0).0, 1 << 2);
        assert_eq!(lanes.get(0).test(&node, 1.0).0, 1 << 2);
        assert_eq!(lanes.meeting(&node, 2, &packet.ray, &[1.0; LANES]), 0xff);
    }

    #[test]
    fn rays_apart_are_no_packet() {
        let alike = |x: f32, y: f32| {
            let mut direction = [[0.5; LANES], [0.25; LANES], [0.0; LANES]];
            let mut origin = [[0.0; LANES]; 3];
            (direction[1][3], origin[2][5]) = (x, y);
            Packet::of(&origin, &direction, true).is_some()
        };
        assert!(alike(0.25, 0.0) && alike(0.3, 0.1));
        assert!(!alike(-0.25, 0.0) && !alike(0.4, 0.0) && !alike(0.25, -0.2));
    }
}
