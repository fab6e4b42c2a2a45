//! The shears of eight rays, computed in lanes: the same as [`Shear::of`] to the last bit.

use crate::geometry::lanes::{Eight, Lanes};
use crate::geometry::ray::Ray;
use crate::geometry::ray_lanes::{LANES, RayLanes, lane_of};
use crate::geometry::scalar::{EightOf, Scalar};
use crate::primitives::shear::{self, Shear};

/// By axis and lane.
#[derive(Debug, Clone, Copy)]
#[repr(align(32))]
pub struct ShearLanes<S> {
    order: [u8; LANES],
    origin: [[S; LANES]; 3],
    shear: [[S; LANES]; 3],
    near: [S; LANES],
    fine: S,
}

/// The axes of the sheared space; in the number's lowest bit whether the longest axis is x, then
/// whether it is y, then whether the ray runs against it.
const AXES: [[usize; 3]; 8] =
    [[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 1, 2], [1, 0, 2], [2, 1, 0], [0, 2, 1], [1, 0, 2]];

impl<S: Scalar> ShearLanes<S> {
    /// Shears of these rays, which `lanes` contains too, for corners with coordinates up to
    /// `magnitude`.
    #[inline(always)]
    pub fn of(rays: &[Ray<S>; LANES], lanes: &RayLanes<S>, magnitude: S) -> Self {
        let splat = EightOf::<S>::splat;
        let vectors = |v: &[[S; LANES]; 3]| {
            [EightOf::<S>::new(v[0]), EightOf::<S>::new(v[1]), EightOf::<S>::new(v[2])]
        };
        let (o, d) = (vectors(&lanes.origin), vectors(&lanes.direction));
        let [ax, ay, az] = [d[0].absolute(), d[1].absolute(), d[2].absolute()];
        let x_above_y = ay.below(ax);
        let is_x = x_above_y & az.below(ax);
        let is_y = splat(S::ZERO).where_set(x_above_y, az.below(ay));
        // in the order that a ray along the last axis sees triangles wound in
        let turned = |v: &[EightOf<S>; 3]| {
            [
                v[1].where_set(is_x, v[2].where_set(is_y, v[0])),
                v[2].where_set(is_x, v[0].where_set(is_y, v[1])),
                v[0].where_set(is_x, v[1].where_set(is_y, v[2])),
            ]
        };
        let ([dp, dq, dz], [op, oq, oz]) = (turned(&d), turned(&o));
        let is_against = dz.below(splat(S::ZERO));
        let (dx, dy) = (dq.where_set(is_against, dp), dp.where_set(is_against, dq));
        let (ox, oy) = (oq.where_set(is_against, op), op.where_set(is_against, oq));
        let inverse = splat(S::ONE) / dz;
        let (x, y) = (dx * inverse, dy * inverse);
        let least = splat(S::LEAST_SLOPE);
        let small = (x.absolute().below(least) | y.absolute().below(least)).high_bits();
        let near = splat(shear::near_factor::<S>()) * (splat(magnitude) + oz.absolute());
        let mut first = x.to_array();
        if small != 0 {
            for (first, ray) in first.iter_mut().zip(rays) {
                *first = Shear::of(ray, magnitude).shear[0];
            }
        }
        let bits = [is_x, is_y, is_against].map(Eight::high_bits);
        let mut order = [0; LANES];
        for (lane, order) in order.iter_mut().enumerate() {
            let bit = |k: usize| bits[k] >> lane & 1;
            *order = (bit(0) | bit(1) << 1 | bit(2) << 2) as u8;
        }
        Self {
            order,
            origin: [ox.to_array(), oy.to_array(), oz.to_array()],
            shear: [first, y.to_array(), inverse.to_array()],
            near: near.to_array(),
            fine: shear::fine(magnitude),
        }
    }

    /// That of a ray.
    #[inline(always)]
    pub fn get(&self, lane: usize) -> Shear<S> {
        let lane = lane & (LANES - 1);
        Shear {
            axes: AXES[usize::from(self.order[lane]) & (AXES.len() - 1)],
            origin: lane_of(&self.origin, lane),
            shear: lane_of(&self.shear, lane),
            fine: self.fine,
            near: self.near[lane],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::scalar::{Vec3, Vector};
    use crate::structures::test_scenes::Random;

    fn agree<S: Scalar>() {
        let mut random = Random(11);
        let special = [0.0, -0.0, 1.0, -1.0, 0.5, 1e-30, -1e-38, 1e-45, 1e-310, 3.0];
        let mut tiny = 0;
        for round in 0..2000 {
            let rays: [Ray<S>; LANES] = std::array::from_fn(|_| {
                let mut number = |is_special: bool| {
                    let x = random.unit() * 4.0 - 2.0;
                    let i = (random.unit() * special.len() as f64) as usize;
                    S::from_f64(if is_special { special[i] } else { x })
                };
                let origin = [0; 3].map(|_| number(false));
                let mut direction = [0; 3].map(|_| number(round % 2 == 0));
                if direction.iter().all(|x| *x == S::ZERO) {
                    direction[round % 3] = S::ONE;
                }
                Ray::new(Vec3::<S>::from_array(origin), Vec3::<S>::from_array(direction))
            });
            let magnitude = S::from_f64(2.0);
            let lanes = ShearLanes::of(&rays, &RayLanes::of(&rays), magnitude);
            for (lane, ray) in rays.iter().enumerate() {
                let bits = |s: Shear<S>| {
                    let numbers = [s.origin, s.shear, [s.fine, s.near, S::ZERO]];
                    // all NaN are one
                    (s.axes, numbers.map(|v| v.map(|x| x.to_f64().max(f64::MIN).to_bits())))
                };
                let expected = Shear::of(ray, magnitude);
                assert_eq!(bits(lanes.get(lane)), bits(expected), "{ray:?}");
                tiny += usize::from(expected.is_too_small());
            }
        }
        assert!(tiny > 100);
    }

    #[test]
    fn shears_in_lanes_are_those_of_single_rays() {
        agree::<f32>();
        agree::<f64>();
    }
}
