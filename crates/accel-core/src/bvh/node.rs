//! A node of eight boxes, and a ray as it is tested against them at once: in units of the scene's
//! size and in f32 first ([`BoxRay`]), which trees of obvhs are traversed with too, then padded
//! ([`NodeRay`]).

use glam::{BVec4A, Vec3, Vec3A, Vec4};
use obvhs::ray::Ray as ObvhsRay;
use wide::f32x8;

use super::slabs::{inverse_of, longest_axis, within};
use crate::geometry::aabb::Aabb;
use crate::geometry::ray::Ray;
use crate::geometry::scalar::{Scalar, Vector};

/// Children of a node at most.
pub(super) const WIDTH: usize = 8;

/// Set in the child of a node that is a leaf.
pub(super) const LEAF: u32 = 1 << 31;

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

/// How rays are told to a tree: in units of the scene's size, so that its largest coordinate lies
/// in [1, 2).
#[derive(Debug, Clone, Copy)]
pub(crate) struct RaySetup<S> {
    /// A power of two.
    pub(super) unit: S,
}

impl<S: Scalar> RaySetup<S> {
    /// For a scene whose largest coordinate is `magnitude`.
    pub(super) fn new(magnitude: S) -> Self {
        Self { unit: magnitude.to_unit_size() }
    }

    /// Factor that coordinates are multiplied by.
    pub(crate) fn unit(&self) -> f64 {
        self.unit.to_f64()
    }

    /// A box as the tree has it, in world units.
    pub(crate) fn world(&self, [low, high]: [[f32; 3]; 2]) -> Aabb<f64> {
        let [min, max] = [low, high].map(|p| Vec3::from_array(p).as_dvec3() / self.unit());
        Aabb { min, max }
    }

    /// The ray as boxes see it.
    #[inline(always)]
    pub(crate) fn ray(&self, ray: &Ray<S>, length: Length) -> BoxRay<S> {
        BoxRay::new(ray, self.unit, length)
    }
}

/// Rule for the length of the ray direction in box tests.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Length {
    /// The ray's own in f32, its largest component in [1, 2) in f64 or where it starts earlier.
    Own,
    /// Its largest component lies in [1, 2) times [`BRIEF`].
    Brief,
}

/// A ray for box tests.
pub(crate) struct BoxRay<S: Scalar> {
    pub(crate) origin: Vec3A,
    pub(crate) direction: Vec3A,
    pub(crate) parameters: BoxParameters<S>,
}

/// Maps our ray parameters to those of a [`BoxRay`].
#[derive(Debug, Clone, Copy)]
pub(crate) struct BoxParameters<S> {
    /// Ratio of its parameters to ours.
    pub(super) scale: S,
    /// Our `t` is at most `t * scale + lead`: how far the ray starts before the true origin, or a
    /// little more.
    pub(super) lead: f32,
}

/// CwBvh ignores boxes that begin or end before t = 1e-4. A ray that starts this much before its
/// origin finds them, in units of the scene's size if the largest component of its direction is in
/// [1, 2).
const LEAD: f32 = 1.0625e-4;
/// For a direction shorter by this factor, 1e-4 is a tenth of an ulp: no padded box ends before it.
const BRIEF: f32 = f32::from_bits((127 - 14) << 23);

/// Half the side of a cube around the origin that holds the scene, in units of its size.
const CUBE: f64 = 3.0;

/// More than the rounding of both terms where a negative parameter and a lead are added: origins
/// lie within 16 of the cube's centre, and so leads are below 20.
const LEAD_SLACK: f32 = 32.0 * f32::EPSILON;

impl<S: Scalar> BoxRay<S> {
    #[inline(always)]
    fn new(ray: &Ray<S>, unit: S, length: Length) -> Self {
        if ray.t_min < S::ZERO {
            return Self::starting_earlier(ray, unit);
        }
        let is_own = length == Length::Own && size_of::<S>() == size_of::<f32>();
        let mut shorter = if is_own { S::ONE } else { ray.unit_factor() };
        let mut lead = 0.0;
        if length == Length::Brief {
            shorter = shorter * S::from_f64(f64::from(BRIEF));
            lead = LEAD;
        }
        let origin = to_f32::<S>(ray.origin * unit);
        Self::scaled(ray, origin, unit, shorter, lead)
    }

    /// Moves the origin of a ray whose interval begins before it.
    #[cold]
    #[inline(never)]
    fn starting_earlier(ray: &Ray<S>, unit: S) -> Self {
        let shorter = ray.unit_factor();
        let (start, lead) = earlier_start(ray, unit, shorter);
        Self::scaled(ray, start, unit, shorter, lead)
    }

    #[inline(always)]
    fn scaled(ray: &Ray<S>, origin: Vec3, unit: S, shorter: S, lead: f32) -> Self {
        let origin = Vec3A::from(origin);
        let direction = Vec3A::from(to_f32::<S>(ray.direction * shorter)) + Vec3A::ZERO;
        let scale = unit / shorter;
        Self { origin, direction, parameters: BoxParameters { scale, lead } }
    }

    /// This for obvhs, up to `t_max`.
    #[inline(always)]
    pub(crate) fn for_obvhs(&self, t_max: S) -> ObvhsRay {
        let (origin, direction) = (self.origin, self.direction);
        // all axes at once
        let is_small = direction.abs().cmplt(Vec3A::splat(1e-30));
        let large = Vec3A::splat(f32::from_bits(0x7180_0000)).copysign(direction);
        let inv_direction = Vec3A::select(is_small, large, direction.recip());
        let tmax = self.parameters.bound(t_max);
        ObvhsRay { origin, direction, inv_direction, tmin: 0.0, tmax }
    }
}

impl<S: Scalar> BoxParameters<S> {
    /// Returns whether its origin is not the true one.
    #[inline(always)]
    pub(crate) fn starts_earlier(&self) -> bool {
        self.lead > 0.0
    }

    /// A bound for box tests that no rounding makes too small (`proofs/ray_end.gappa`).
    #[inline(always)]
    pub(crate) fn bound(&self, t_max: S) -> f32 {
        let t = (t_max * self.scale).to_f64() as f32;
        // 0 * infinity: `max` gives 0 for NaN
        (t + self.lead).max(0.0) * (1.0 + 2.0 * f32::EPSILON)
    }
}

/// The start of a ray whose interval begins before its origin, and its lead: at the begin of the
/// interval, or where the ray enters the cube around the scene if that is later.
fn earlier_start<S: Scalar>(ray: &Ray<S>, unit: S, shorter: S) -> (Vec3, f32) {
    let origin = ray.origin.to_dvec3() * unit.to_f64();
    let direction = ray.direction.to_dvec3() * shorter.to_f64();
    let (o, d) = (origin.to_array(), direction.to_array());
    let mut start = ray.t_min.to_f64() * (unit / shorter).to_f64();
    for k in 0..3 {
        if d[k] != 0.0 {
            start = start.max((-CUBE.copysign(d[k]) - o[k]) / d[k]);
        }
    }
    // never later than rays without negative parameters
    let start = start.min(0.0) - f64::from(LEAD);
    ((origin + direction * start).as_vec3(), -start as f32 + LEAD_SLACK)
}

#[inline(always)]
fn to_f32<S: Scalar>(v: crate::Vec3<S>) -> Vec3 {
    let [x, y, z] = v.to_array();
    Vec3::new(x.to_f64() as f32, y.to_f64() as f32, z.to_f64() as f32)
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
/// shifted: where a reciprocal is cut off (`slabs.rs`), a plane is met too early.
pub(super) const LEAST_PART: f32 = 1.0 / 512.0;
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
        let [o, d] = [o.extend(0.0), d.extend(0.0)];
        let inverse = inverse_of(d);
        let shift = SHIFT[0] + SHIFT[1] * longest_axis(o);
        let shift = (shift * EPSILON).copysign(d);
        let is_shifted =
            if is_exact { d.abs().cmplt(longest_axis(d) * LEAST_PART) } else { BVec4A::TRUE };
        let leave_origin = o - Vec4::select(is_shifted, shift, Vec4::ZERO);
        let leave = leave_origin * inverse;
        let mut rounding = leave.abs() * PRODUCT_ROUNDING;
        // a product with 0 would be computed, and waited for
        if PLANE_ROUNDING > 0.0 {
            rounding += inverse.abs() * PLANE_ROUNDING;
        }
        Self::of_lanes(inverse, [-((o + shift) * inverse), rounding - leave])
    }

    /// The same from lanes, three of them for the axes.
    #[inline(always)]
    fn of_lanes(inverse: Vec4, offset: [Vec4; 2]) -> Self {
        let axes = |v: Vec4| v.truncate().to_array();
        let octant = inverse.is_negative_bitmask() & (OCTANTS as u32 - 1);
        Self::with([axes(inverse); 2], [axes(offset[0]), axes(offset[1])], octant)
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
        let inverse = inverse_of(d.extend(0.0));
        // never -0: see `within`
        let offset = Vec4::ZERO - o.extend(0.0) * inverse;
        Self::of_lanes(inverse, [offset; 2])
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
        let planes = |side| [plane(0, side), plane(1, side), plane(2, side)];
        within(planes(0), planes(1), f32x8::splat(end))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::structures::test_scenes::Random;

    #[test]
    fn a_box_that_ends_where_a_ray_begins_is_met() {
        let mut random = Random(72);
        for round in 0..200_000 {
            let [mut o, mut d] = [0; 2].map(|_| (random.point([2.0; 3]) - 1.0).as_vec3a());
            // on a plane through the scene's origin, or along it
            match round % 8 {
                axis @ 0..3 => o[axis] = 0.0,
                axis @ 3..6 => d[axis - 3] = 0.0,
                _ => {}
            }
            let mut node = Node::empty();
            node.set_box(3, o.to_array(), o.to_array());
            assert_eq!(NodeRay::of(o, d, true).test(&node, 1.0).0, 8, "{o} {d}");
        }
    }
}
