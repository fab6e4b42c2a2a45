//! Eight rays as nodes are tested with them, made in lanes: the same as [`RaySetup::ray`] and
//! [`NodeRay::of`] to the last bit.

use wide::f32x8;

use super::node::{
    BoxParameters, EPSILON, LEAST_PART, Node, NodeRay, PLANE_ROUNDING, PRODUCT_ROUNDING, RaySetup,
    SHIFT,
};
use super::slabs::{LARGE, within};
use crate::geometry::lanes::{Eight, Lanes};
use crate::geometry::ray::unit_factor;
use crate::geometry::ray_lanes::{LANES, RayLanes, lane_of};
use crate::geometry::scalar::Scalar;

/// Eight rays for box tests, by axis and lane.
pub(super) struct BoxRayLanes<S: Scalar> {
    pub(super) origin: [[f32; LANES]; 3],
    pub(super) direction: [[f32; LANES]; 3],
    pub(super) parameters: [BoxParameters<S>; LANES],
}

impl<S: Scalar> RaySetup<S> {
    /// [`RaySetup::ray`] of `Length::Own` for eight rays whose intervals begin at their origins
    /// or later.
    #[inline(always)]
    pub(super) fn ray_lanes(&self, rays: &RayLanes<S>) -> BoxRayLanes<S> {
        let unit = self.unit;
        let is_own = size_of::<S>() == size_of::<f32>();
        let mut lanes = BoxRayLanes {
            origin: [[0.0; LANES]; 3],
            direction: [[0.0; LANES]; 3],
            parameters: [BoxParameters { scale: unit, lead: 0.0 }; LANES],
        };
        for lane in 0..LANES {
            let direction = lane_of(&rays.direction, lane);
            let shorter = if is_own { S::ONE } else { unit_factor(direction) };
            lanes.parameters[lane].scale = unit / shorter;
            for (k, d) in direction.into_iter().enumerate() {
                lanes.origin[k][lane] = (rays.origin[k][lane] * unit).to_f64() as f32;
                // -0 becomes 0
                lanes.direction[k][lane] = (d * shorter).to_f64() as f32 + 0.0;
            }
        }
        lanes
    }
}

/// By axis and lane; of planes where boxes are entered, and of those where they are left.
#[derive(Debug, Clone, Copy)]
#[repr(align(32))]
pub(super) struct NodeRayLanes {
    inverse: [[f32; LANES]; 3],
    offset: [[[f32; LANES]; 3]; 2],
}

impl NodeRayLanes {
    /// As [`NodeRay::of`] takes them, by axis and lane.
    #[inline(always)]
    pub(super) fn of(
        origin: &[[f32; LANES]; 3],
        direction: &[[f32; LANES]; 3],
        is_exact: bool,
    ) -> Self {
        let splat = f32x8::splat;
        let vectors =
            |v: &[[f32; LANES]; 3]| [f32x8::new(v[0]), f32x8::new(v[1]), f32x8::new(v[2])];
        let largest =
            |v: &[f32x8; 3]| v[0].absolute().greater(v[1].absolute()).greater(v[2].absolute());
        let (o, d) = (vectors(origin), vectors(direction));
        let longest = largest(&d);
        let shift = (splat(SHIFT[0]) + splat(SHIFT[1]) * largest(&o)) * splat(EPSILON);
        // of a ray that is not exact all axes
        let least = if is_exact { longest * splat(LEAST_PART) } else { splat(f32::INFINITY) };
        let nothing = [[0.0; LANES]; 3];
        let mut this = Self { inverse: nothing, offset: [nothing; 2] };
        for k in 0..3 {
            let inverse = (splat(1.0) / d[k]).lesser(splat(LARGE)).greater(splat(-LARGE));
            let shift = shift.copysign(d[k]);
            let is_shifted = d[k].absolute().below(least);
            let leave_origin = o[k] - (shift & is_shifted);
            let leave = leave_origin * inverse;
            let rounding = leave.absolute() * splat(PRODUCT_ROUNDING)
                + inverse.absolute() * splat(PLANE_ROUNDING);
            this.inverse[k] = inverse.to_array();
            this.offset[0][k] = (-((o[k] + shift) * inverse)).to_array();
            this.offset[1][k] = (rounding - leave).to_array();
        }
        this
    }

    /// A bit for each of the rays that meets the box of a child before it ends: what
    /// [`NodeRay::test`] says. All run into the octant of `like`.
    #[inline(always)]
    pub(super) fn meeting(
        &self,
        node: &Node,
        child: usize,
        like: &NodeRay,
        ends: &[f32; LANES],
    ) -> u32 {
        let [low, high] = like.bounds(node, child);
        let plane = |bound: [f32; 3], side: usize, k: usize| {
            let (inverse, offset) = (self.inverse[k], self.offset[side][k]);
            f32x8::splat(bound[k]).mul_add(f32x8::new(inverse), f32x8::new(offset))
        };
        let planes = |bound, side| [0, 1, 2].map(|k| plane(bound, side, k));
        within(planes(low, 0), planes(high, 1), f32x8::new(*ends)).0
    }

    /// That of a ray.
    #[inline(always)]
    pub(super) fn get(&self, lane: usize) -> NodeRay {
        let lane = lane & (LANES - 1);
        let inverse = lane_of(&self.inverse, lane);
        let is_negative = |k: usize| u32::from(inverse[k].is_sign_negative()) << k;
        let octant = is_negative(0) | is_negative(1) | is_negative(2);
        NodeRay::with(
            [inverse; 2],
            [lane_of(&self.offset[0], lane), lane_of(&self.offset[1], lane)],
            octant,
        )
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3A;

    use super::*;
    use crate::structures::test_scenes::Random;

    #[test]
    fn rays_in_lanes_are_those_of_single_rays() {
        let mut random = Random(12);
        for round in 0..2000 {
            let mut number = |scale: f64| {
                let x = (random.unit() * 2.0 - 1.0) * scale;
                if random.unit() < 0.2 { 0.0 } else { x as f32 }
            };
            let origin = [0; 3].map(|_| [0; LANES].map(|_| number(16.0)));
            let mut direction = [0; 3].map(|_| [0; LANES].map(|_| number(1.0)));
            direction[round % 3] = [0; LANES].map(|_| 1e-3 + number(1e-4).abs());
            // no component is -0
            direction = direction.map(|lanes| lanes.map(|x| x + 0.0));
            for is_exact in [true, false] {
                let lanes = NodeRayLanes::of(&origin, &direction, is_exact);
                for lane in 0..LANES {
                    let of = |v: &[[f32; LANES]; 3]| Vec3A::from(lane_of(v, lane));
                    let expected = NodeRay::of(of(&origin), of(&direction), is_exact);
                    assert_eq!(lanes.get(lane), expected, "{round} {lane}");
                }
            }
        }
    }
}
