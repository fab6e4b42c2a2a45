//! A node of eight boxes, which a ray is tested against at once.

use glam::{BVec3A, Vec3A};
use wide::f32x8;

use super::collapse::{LEAF, WIDTH};
use crate::geometry::lanes::{Eight, Lanes};

/// Eight boxes in f32, by plane; 224 bytes in four cache lines of their own, which is faster than without
/// the gap.
#[repr(C, align(64))]
#[derive(Debug, Clone, Copy)]
pub(super) struct Node {
    /// Lower planes on x, y, z, then upper ones; a box that is none has them the wrong way round.
    planes: [f32x8; 6],
    /// Number of a node, or that of a list with [`LEAF`].
    pub(super) children: [u32; WIDTH],
}

impl Node {
    /// Without children.
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
/// Boxes are padded for the rounding of a triangle's corners at its own extent
/// (`Padding::OfExtent`). What is missing, is added to the ray, so that boxes are found that hold a hit:
/// * Where it enters: all that a hit's point may lie outside of its triangle's box
///   (`primitives/precise.rs`), as a shift of the origin.
/// * Where it leaves: the rounding of corners at the hit's distance, as a factor (an angle); on axes along
///   which the ray hardly runs, as a shift; and the rounding of the ray's products, about an ulp of its
///   origin's coordinate. No more, so that a ray which leaves a face is not within the boxes of that face. A
///   triangle whose box ends behind the origin is not hit: that holds of the watertight test in f32; for other
///   primitives both ends are shifted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct NodeRay {
    /// A plane is met at `plane * inverse + offset`: planes where boxes are entered, and those where they are
    /// left.
    inverse: [[f32x8; 3]; 2],
    offset: [[f32x8; 3]; 2],
    /// Of the planes where boxes are entered, by axis, and of those where they are left: see [`PLANES`].
    planes: &'static [[usize; 3]; 2],
}

/// By which octant a direction lies in: axis `k` is bit `k`, set where it is negative.
const OCTANTS: usize = 8;

/// By octant, where the planes that its rays meet first, and last, stand in a node: bytes from its begin.
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
/// Components of a direction that are a smaller part of the largest one make too large a factor.
pub(super) const LEAST_PART: f32 = 1.0 / 512.0;
/// More than the reciprocal of any component that counts, and less than overflows in a scene of unit
/// size.
pub(super) const LARGE: f32 = 1e37;
/// Where a plane's product is rounded before the ray's offset is added: coordinates are below 2.
pub(super) const PLANE_ROUNDING: f32 =
    if cfg!(target_feature = "fma") { 0.0 } else { f32::EPSILON };

impl NodeRay {
    /// Of a ray in a scene of unit size, its direction neither longer than 1e18 nor shorter than 1e-18, no
    /// component -0. `is_exact`: a triangle that ends behind the origin is not hit.
    #[inline(always)]
    pub(super) fn of(o: Vec3A, d: Vec3A, is_exact: bool) -> Self {
        let inverse = d.recip().min(Vec3A::splat(LARGE)).max(Vec3A::splat(-LARGE));
        // 24 epsilons of the largest coordinate, below 2, for weights; 5 of distances for corners; 4 for
        // the slab; 1 of each for products; the rounding of the origin in f64
        let shift = Vec3A::splat((66.0 + 10.0 * o.abs().max_element()) * EPSILON).copysign(d);
        let longest = d.abs().max_element();
        let is_shifted = match is_exact {
            true => d.abs().cmplt(Vec3A::splat(longest * LEAST_PART)),
            false => BVec3A::TRUE,
        };
        // a corner is off by 5 epsilons of the distance; 3 for the slab
        let angle = inverse.abs() * (longest * (5.0 * EPSILON)) + (1.0 + 3.0 * EPSILON);
        let longer = Vec3A::select(is_shifted, Vec3A::splat(1.0 + 4.0 * EPSILON), angle);
        let leave_origin = o - Vec3A::select(is_shifted, shift, Vec3A::ZERO);
        let leave_inverse = inverse * longer;
        let leave = leave_origin * leave_inverse;
        let rounding = leave.abs() * (2.0 * EPSILON) + leave_inverse.abs() * PLANE_ROUNDING;
        let enter_offset = -((o + shift) * inverse);
        let leave_offset = rounding - leave;
        Self::with(
            [inverse.to_array(), leave_inverse.to_array()],
            [enter_offset.to_array(), leave_offset.to_array()],
            inverse.is_negative_bitmask(),
        )
    }

    /// Of what it is made of; of the octant that it runs into, see [`OCTANTS`].
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

    /// Where a child's box is entered, by axis, and where it is left, by rays into the octant of this one.
    #[inline(always)]
    pub(super) fn bounds(&self, node: &Node, child: usize) -> [[f32; 3]; 2] {
        let bound = |side: usize, k: usize| {
            let at = self.planes[side][k] + (child & (WIDTH - 1)) * size_of::<f32>();
            // SAFETY: `PLANES` has the places of planes of `WIDTH` bounds, which come first in a node
            unsafe { *std::ptr::from_ref(node).byte_add(at).cast::<f32>() }
        };
        [[bound(0, 0), bound(0, 1), bound(0, 2)], [bound(1, 0), bound(1, 1), bound(1, 2)]]
    }

    /// The same without anything added, for the price of it.
    #[cfg(feature = "compiled-tests")]
    #[inline(always)]
    pub(super) fn plain(o: Vec3A, d: Vec3A) -> Self {
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
