//! Eight triangles of a block against one ray, by other tests than the watertight one: each the
//! same operations as its scalar test, in the same order, so that lanes round as scalars do.
//!
//! Papers: as `triangle.rs` and `variants/triangle_tests.rs`. Each answers which lanes are hit
//! within `[ray.t_min, t_max]`, the lowest bit the first lane, and their parameters. Lanes without
//! a triangle hold NaN, which fails all comparisons.

use crate::geometry::lanes::{Eight, Lanes, take_lowest};
use crate::geometry::ray::Ray;
use crate::geometry::scalar::{EightOf, Scalar, Vector};
use crate::primitives::shear::Shear;
use crate::primitives::triangle_block::{TriangleBlock, sheared};

/// Result of a block test.
type BlockResult<S> = (u32, [S; 8]);
/// A vector in each lane.
type Vectors<S> = [EightOf<S>; 3];

#[inline(always)]
fn less<S: Scalar>(a: Vectors<S>, b: Vectors<S>) -> Vectors<S> {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[inline(always)]
fn dot<S: Scalar>(a: Vectors<S>, b: Vectors<S>) -> EightOf<S> {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
fn cross<S: Scalar>(a: Vectors<S>, b: Vectors<S>) -> Vectors<S> {
    [a[1] * b[2] - b[1] * a[2], a[2] * b[0] - b[2] * a[0], a[0] * b[1] - b[0] * a[1]]
}

#[inline(always)]
fn splat<S: Scalar>(v: [S; 3]) -> Vectors<S> {
    v.map(EightOf::<S>::splat)
}

#[inline(always)]
fn corners<S: Scalar>(block: &TriangleBlock<S>) -> [Vectors<S>; 3] {
    block.corners().map(|corner| corner.map(EightOf::<S>::new))
}

/// Lanes whose parameter lies in the interval.
#[inline(always)]
fn within<S: Scalar>(t: EightOf<S>, ray: &Ray<S>, t_max: S) -> EightOf<S> {
    EightOf::<S>::splat(ray.t_min).at_most(t) & t.at_most(EightOf::<S>::splat(t_max))
}

/// Moeller and Trumbore, hits accepted up to `tolerance` outside in barycentric coordinates.
#[inline(always)]
pub(crate) fn moeller_trumbore<S: Scalar>(
    block: &TriangleBlock<S>,
    ray: &Ray<S>,
    t_max: S,
    tolerance: S,
) -> BlockResult<S> {
    let one = |x: S| EightOf::<S>::splat(x);
    let [a, b, c] = corners(block);
    let (e1, e2) = (less::<S>(b, a), less::<S>(c, a));
    let d = splat(ray.direction.to_array());
    let p = cross::<S>(d, e2);
    let det = dot::<S>(e1, p);
    let inv = one(S::ONE) / det;
    let s = less::<S>(splat(ray.origin.to_array()), a);
    let u = dot::<S>(s, p) * inv;
    let q = cross::<S>(s, e1);
    let v = dot::<S>(d, q) * inv;
    let least = one(-tolerance);
    let is_inside = least.at_most(u) & least.at_most(v) & (u + v).at_most(one(S::ONE + tolerance));
    // a zero determinant has no finite reciprocal: u is infinite or NaN, and so is u + v
    if is_inside.high_bits() == 0 {
        return (0, [S::ZERO; 8]);
    }
    let t = dot::<S>(e2, q) * inv;
    let flat = det.equal(one(S::ZERO)).high_bits();
    ((is_inside & within(t, ray, t_max)).high_bits() & !flat, t.to_array())
}

/// The signs of the ray against each edge.
#[inline(always)]
pub(crate) fn pluecker<S: Scalar>(
    block: &TriangleBlock<S>,
    ray: &Ray<S>,
    t_max: S,
) -> BlockResult<S> {
    let zero = EightOf::<S>::splat(S::ZERO);
    let origin = splat(ray.origin.to_array());
    let [a, b, c] = corners(block).map(|corner| less::<S>(corner, origin));
    let d = splat(ray.direction.to_array());
    let u = dot::<S>(d, cross::<S>(c, b));
    let v = dot::<S>(d, cross::<S>(a, c));
    let w = dot::<S>(d, cross::<S>(b, a));
    let missed = (u.lesser(v).lesser(w).below(zero)) & zero.below(u.greater(v).greater(w));
    if missed.high_bits() == 0xff {
        return (0, [S::ZERO; 8]);
    }
    let normal = cross::<S>(less::<S>(b, a), less::<S>(c, a));
    let det = dot::<S>(d, normal);
    let t = dot::<S>(a, normal) / det;
    let refused = missed.high_bits() | det.equal(zero).high_bits();
    (within(t, ray, t_max).high_bits() & !refused, t.to_array())
}

/// The watertight test as published: lanes where an edge function is zero are left to `again`, the
/// scalar test of a triangle.
#[inline(always)]
pub(crate) fn watertight_fallback<S: Scalar>(
    block: &TriangleBlock<S>,
    ray: &Ray<S>,
    shear: &Shear<S>,
    t_max: S,
    again: impl Fn(&[[S; 3]; 3]) -> Option<S>,
) -> BlockResult<S> {
    let zero = EightOf::<S>::splat(S::ZERO);
    let [a, b, c] = sheared(block.corners(), shear);
    let u = c[0] * b[1] - c[1] * b[0];
    let v = a[0] * c[1] - a[1] * c[0];
    let w = b[0] * a[1] - b[1] * a[0];
    let (least, most) = (u.lesser(v).lesser(w), u.greater(v).greater(w));
    let missed = least.below(zero) & zero.below(most);
    let doubtful = (u.equal(zero) | v.equal(zero) | w.equal(zero)).high_bits();
    if missed.high_bits() & !doubtful == 0xff {
        return (0, [S::ZERO; 8]);
    }
    let det = u + v + w;
    let depth = u * a[2] + v * b[2] + w * c[2];
    let t = depth * EightOf::<S>::splat(shear.depth_scale()) / det;
    let refused = missed.high_bits() | det.equal(zero).high_bits() | doubtful;
    let mut lanes = within(t, ray, t_max).high_bits() & !refused;
    let mut t = t.to_array();
    let mut left = doubtful;
    while left != 0 {
        let lane = take_lowest(&mut left);
        if let Some(found) = again(&block.triangle(lane)) {
            t[lane] = found;
            lanes |= 1 << lane;
        }
    }
    (lanes, t)
}
