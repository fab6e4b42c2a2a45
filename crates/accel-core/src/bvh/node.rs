//! A node of eight boxes, which a ray is tested against at once.

use glam::{BVec3A, Vec3A};
use wide::f32x8;

use super::collapse::{LEAF, WIDTH};
use crate::geometry::lanes::{Eight, Lanes};

/// Eight boxes in f32, by plane; 224 bytes in four cache lines of their own, which is faster than
/// without the gap.
#[repr(C, align(64))]
#[derive(Debug, Clone, Copy)]
pub(super) struct Node {
    /// Lower planes on x, y, z, then upper ones; empty slots have min > max.
    planes: [f32x8; 6],
    /// Number of a node, or that of a list with [`LEAF`].
    pub(super) children: [u32; WIDTH],
}

impl Node {
    pub(super) fn empty() -> Self {
        let [low, high] = [f32::INFINITY, f32::NEG_INFINITY].map(f32x8::splat);
        Self { planes: [low, low, low, high, high, high], children: [LEAF; WIDTH] }
    }

    /// The box of a child; none where there is none.
    pub(super) fn child_box(&self, child: usize) -> Option<[[f32; 3]; 2]> {
        let plane = |side: usize, k: usize| self.planes[3 * side + k].to_array()[child];
        let [low, high] = [0, 1].map(|side| std::array::from_fn(|k| plane(side, k)));
        (low[0] <= high[0]).then_some([low, high])
    }

    /// Sets the box of a child.
    pub(super) fn set_box(&mut self, child: usize, low: [f32; 3], high: [f32; 3]) {
        for (plane, x) in self.planes.iter_mut().zip(low.into_iter().chain(high)) {
            plane.as_mut_array()[child] = x;
        }
    }
}

/// A ray as nodes are tested with it.
///
/// Boxes are padded for what the rounding of corners does at a triangle's own extent
/// (`Padding::OF_CORNERS`). What is missing is added to the ray, so that boxes are found that hold
/// a hit:
/// * Where it enters: all that rounding does besides, to either end, as a shift of the origin.
/// * Where it leaves: the rounding of the origin's product, about an ulp of its coordinate; on axes
///   along which the ray hardly runs the shift, too. No more, so that a ray which leaves a face is
///   not within the boxes of that face. For primitives other than triangles under the watertight
///   test in f32 both ends are shifted.
///
/// That test hits, at no negative parameter, a point of the triangle of its rounded corners: it
/// finds signs exactly (`primitives/precise.rs`). A corner at `a` along an axis and `z` along the
/// longest axis of the direction, from the origin, is rounded by half an epsilon of `|a| + |s z| +
/// |a - s z|`, where `s` is the slope, and along the longest axis of `z`. The point is a mean of
/// corners, weighted; so is what it is off by. The mean of absolute values of numbers spread over
/// an extent is at most that of the numbers and half the extent, and `a - s z` has the mean 0. So
/// the point is off by half an epsilon of twice its distance along the axis, of the extent along it
/// and of that along the longest one. The extents are in the padding. The distance, which is none
/// where a box ends behind the origin, is in the shift.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct NodeRay {
    /// A plane is met at `plane * inverse + offset`: planes where boxes are entered, and those
    /// where they are left.
    inverse: [[f32x8; 3]; 2],
    offset: [[f32x8; 3]; 2],
    /// Indices of the entry and exit planes of boxes, by axis: see [`PLANES`].
    planes: &'static [[usize; 3]; 2],
}

/// By which octant a direction lies in: axis `k` is bit `k`, set where it is negative.
const OCTANTS: usize = 8;

/// By octant, where the planes that its rays meet first, and last, stand in a node: bytes from its
/// begin.
static PLANES: [[[usize; 3]; 2]; OCTANTS] = {
    let mut all = [[[0; 3]; 2]; OCTANTS];
    let mut octant = 0;
    while octant < OCTANTS {
        let mut k = 0;
        while k < 3 {
            let is_negative = octant >> k & 1;
            all[octant][0][k] = (k + 3 * is_negative) * size_of::<f32x8>();
            all[octant][1][k] = (k + 3 * (1 - is_negative)) * size_of::<f32x8>();
            k += 1;
        }
        octant += 1;
    }
    all
};

pub(super) const EPSILON: f32 = f32::EPSILON;
/// Along axes on which a direction has a smaller part of its largest component both ends are
/// shifted: where a reciprocal is cut off ([`LARGE`]), a plane is met too early.
pub(super) const LEAST_PART: f32 = 1.0 / 512.0;
/// More than the reciprocal of any component that counts, and less than overflows in a scene of
/// unit size.
pub(super) const LARGE: f32 = 1e37;
/// By so many epsilons, and so many of the origin's largest coordinate, origins are shifted. 24 of
/// a scene's largest coordinate, below 2, for weights; of a hit's distance, below that and the
/// origin's, 2.5 for corners and the slope, 4.5 for the parameter; and the slab's own roundings. A
/// ray in f64, which is rounded to f32 for boxes, needs less (`proofs/node_entry.gappa`,
/// `packet.gappa`).
pub(super) const SHIFT: [f32; 2] = [50.0, 10.0];
/// Rounding error of the product with a ray's origin, and of the sum with it
/// (`proofs/node_exit.gappa`).
pub(super) const PRODUCT_ROUNDING: f32 = (1.0 + 1.0 / 32.0) * EPSILON;
/// Rounding error of the product with a plane, before the ray's offset is added: coordinates are
/// below 2.
pub(super) const PLANE_ROUNDING: f32 =
    (if cfg!(target_feature = "fma") { 0.0 } else { 1.0 }) * EPSILON;

impl NodeRay {
    /// Prepares a ray in a scene of unit size. Its direction has a length from 1e-18 to 1e18 and no
    /// component -0. `is_exact`: a triangle that ends behind the origin is not hit.
    #[inline(always)]
    pub(super) fn of(o: Vec3A, d: Vec3A, is_exact: bool) -> Self {
        let inverse = d.recip().min(Vec3A::splat(LARGE)).max(Vec3A::splat(-LARGE));
        let shift = SHIFT[0] + SHIFT[1] * o.abs().max_element();
        let shift = Vec3A::splat(shift * EPSILON).copysign(d);
        let longest = d.abs().max_element();
        let is_shifted =
            if is_exact { d.abs().cmplt(Vec3A::splat(longest * LEAST_PART)) } else { BVec3A::TRUE };
        let leave_origin = o - Vec3A::select(is_shifted, shift, Vec3A::ZERO);
        let leave = leave_origin * inverse;
        let rounding = leave.abs() * PRODUCT_ROUNDING + inverse.abs() * PLANE_ROUNDING;
        let enter_offset = -((o + shift) * inverse);
        let leave_offset = rounding - leave;
        Self::with(
            [inverse.to_array(); 2],
            [enter_offset.to_array(), leave_offset.to_array()],
            inverse.is_negative_bitmask(),
        )
    }

    /// Assembles its parts; for the octant see [`OCTANTS`].
    #[inline(always)]
    pub(super) fn with(inverse: [[f32; 3]; 2], offset: [[f32; 3]; 2], octant: u32) -> Self {
        // one by one: `map` of arrays of arrays becomes a call
        let splat = |[x, y, z]: [f32; 3]| [f32x8::splat(x), f32x8::splat(y), f32x8::splat(z)];
        Self {
            inverse: [splat(inverse[0]), splat(inverse[1])],
            offset: [splat(offset[0]), splat(offset[1])],
            planes: &PLANES[octant as usize & (OCTANTS - 1)],
        }
    }

    /// Entry and exit planes of a child's box, by axis, for rays into the octant of this one.
    #[inline(always)]
    pub(super) fn bounds(&self, node: &Node, child: usize) -> [[f32; 3]; 2] {
        let bound = |side: usize, k: usize| {
            let at = self.planes[side][k] + (child & (WIDTH - 1)) * size_of::<f32>();
            // SAFETY: `PLANES` has the places of planes of `WIDTH` bounds, which come first in a
            // node
            unsafe { *std::ptr::from_ref(node).byte_add(at).cast::<f32>() }
        };
        [[bound(0, 0), bound(0, 1), bound(0, 2)], [bound(1, 0), bound(1, 1), bound(1, 2)]]
    }

    /// The same without anything added, for the price of it.
    #[inline(always)]
    pub(super) fn unpadded(o: Vec3A, d: Vec3A) -> Self {
        let inverse = d.recip().min(Vec3A::splat(LARGE)).max(Vec3A::splat(-LARGE));
        let offset = (-(o * inverse)).to_array();
        Self::with([inverse.to_array(); 2], [offset; 2], inverse.is_negative_bitmask())
    }

    /// Boxes that the ray meets up to parameter `end`, a bit each, and where it enters them.
    #[inline(always)]
    pub(super) fn test(&self, node: &Node, end: f32) -> (u32, f32x8) {
        let plane = |k: usize, side: usize| {
            // SAFETY: `PLANES` has the places of planes, which come first in a node
            let plane =
                unsafe { *std::ptr::from_ref(node).byte_add(self.planes[side][k]).cast::<f32x8>() };
            plane.mul_add(self.inverse[side][k], self.offset[side][k])
        };
        let enter = plane(0, 0).greater(plane(1, 0));
        let enter = enter.greater(plane(2, 0).greater(f32x8::ZERO));
        let leave = plane(0, 1).lesser(plane(1, 1));
        let leave = leave.lesser(plane(2, 1).lesser(f32x8::splat(end)));
        (enter.at_most(leave).high_bits(), enter)
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::bvh::box_ray::{BoxRay, Length};
    use crate::bvh::items::{Padding, boxes};
    use crate::geometry::ray::Ray;
    use crate::primitives::{PrimSet, TriangleSet, Watertight};
    use crate::structures::test_scenes::Random;

    /// One of these powers of ten, evenly by logarithm.
    fn power(random: &mut Random, low: f64, high: f64) -> f64 {
        10f64.powf(low + (high - low) * random.unit())
    }

    fn signed(random: &mut Random) -> DVec3 {
        random.point([2.0; 3]) - 1.0
    }

    /// Half of them flat on an axis, a third narrow; far from the origin of coordinates, or around
    /// it.
    fn triangle(random: &mut Random) -> [DVec3; 3] {
        let (size, at) = (power(random, -5.0, 0.0), signed(random) * power(random, -6.0, 0.0));
        let narrow = if random.unit() < 0.3 { power(random, -5.0, 0.0) } else { 1.0 };
        let mut edges = [signed(random) * size, signed(random) * (size * narrow)];
        let axis = (random.unit() * 6.0) as usize;
        if axis < 3 {
            edges.iter_mut().for_each(|e| e[axis] = 0.0);
        }
        let [a, b] = edges;
        [at - (a + b) / 3.0, at + a, at + b].map(|p| p.clamp(DVec3::splat(-1.0), DVec3::ONE))
    }

    /// At a point of a triangle, often on its outline, from however near.
    fn ray(random: &mut Random, [a, b, c]: [DVec3; 3]) -> Ray<f32> {
        let [u, v] = [0; 2].map(|_| if random.unit() < 0.3 { 0.0 } else { random.unit() });
        let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
        let point = a + (b - a) * u + (c - a) * v;
        let mut d = signed(random);
        if random.unit() < 0.5 {
            let part = power(random, -4.0, 0.0);
            d[(random.unit() * 3.0) as usize] *= part;
        }
        let t = match (random.unit() * 3.0) as u32 {
            0 => 0.0,
            1 => power(random, -8.0, -5.0) * (random.unit() - 0.2),
            _ => power(random, -5.0, 0.5),
        };
        let mut o = (point - d * t).as_vec3();
        for k in 0..3 {
            for _ in 0..(random.unit() * 5.0) as u32 {
                o[k] = if random.unit() < 0.5 { o[k].next_up() } else { o[k].next_down() };
            }
        }
        Ray::new(o, d.as_vec3())
    }

    /// By ray: whether the triangle is hit, and whether its box is met.
    fn hits_and_boxes(rounds: u32) -> Vec<[bool; 2]> {
        let mut random = Random(71);
        let mut all = Vec::new();
        for _ in 0..rounds {
            let triangles: [_; WIDTH] =
                std::array::from_fn(|_| triangle(&mut random).map(|p| p.as_vec3()));
            let corners = triangles.map(|t| t.map(|p| p.to_array())).to_vec();
            let set = TriangleSet::<f32, Watertight>::new(corners, |_| false).unwrap();
            let (boxes, setup) = boxes(&set, "", Padding::OF_CORNERS).unwrap();
            let mut node = Node::empty();
            for (child, b) in boxes.iter().enumerate() {
                node.set_box(child, b.min.to_array(), b.max.to_array());
            }
            for number in 0..WIDTH * 8 {
                let id = number % WIDTH;
                let ray = ray(&mut random, triangles[id].map(|p| p.as_dvec3()));
                if ray.direction.abs().max_element() < 1e-3 {
                    continue;
                }
                let hit = set.intersect(id as u32, &ray, &set.setup(&ray), f32::INFINITY);
                let BoxRay { origin, direction, parameters } = setup.ray(&ray, Length::Own);
                let of_nodes = NodeRay::of(origin, direction, true);
                let end = parameters.bound(hit.unwrap_or(f32::INFINITY));
                all.push([hit.is_some(), of_nodes.test(&node, end).0 >> id & 1 == 1]);
            }
        }
        all
    }

    #[test]
    fn a_box_that_ends_where_a_ray_begins_is_met() {
        let mut random = Random(72);
        for _ in 0..100_000 {
            let [o, d] = [0; 2].map(|_| signed(&mut random).as_vec3a());
            let mut node = Node::empty();
            node.set_box(3, o.to_array(), o.to_array());
            assert_eq!(NodeRay::of(o, d, true).test(&node, 1.0).0, 8, "{o} {d}");
        }
    }

    #[test]
    fn a_triangle_that_is_hit_has_a_box_that_is_met() {
        let all = hits_and_boxes(40_000);
        let count = |wanted: [bool; 2]| all.iter().filter(|found| **found == wanted).count();
        assert_eq!(count([true, false]), 0);
        let counts = [count([true, true]), count([false, false])];
        assert!(counts[0] > 1_000_000 && counts[1] > 50_000, "{counts:?}");
    }
}
