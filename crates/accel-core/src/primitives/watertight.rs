//! The watertight test of one triangle; paper and deviations as in `triangle.rs`.

use crate::geometry::ray::Ray;
use crate::geometry::scalar::Scalar;
use crate::primitives::precise::{self, exact_difference, weights_suffice};
use crate::primitives::shear::Shear;

/// The largest coordinate of sheared corners across the ray.
#[inline(always)]
fn largest<S: Scalar>([a, b, c]: &[[S; 3]; 3]) -> S {
    let x = a[0].abs().greater(b[0].abs()).greater(c[0].abs());
    let y = a[1].abs().greater(b[1].abs()).greater(c[1].abs());
    x.greater(y)
}

/// The largest sum of an edge function's two products, without their signs.
#[inline(always)]
fn terms<S: Scalar>([a, b, c]: &[[S; 3]; 3]) -> S {
    let of = |p: &[S; 3], q: &[S; 3]| (p[0] * q[1]).abs() + (p[1] * q[0]).abs();
    of(c, b).greater(of(a, c)).greater(of(b, a))
}

/// `a*b - c*d` with the right sign: where the rounded products cancel, the sign of the exact
/// difference (of the rounding errors) decides. Never contract this into one FMA: that breaks
/// the antisymmetry that makes shared edges tight.
#[inline(always)]
pub(crate) fn edge_function<S: Scalar>(a: S, b: S, c: S, d: S) -> S {
    let e = a * b - c * d;
    if e == S::ZERO { exact_difference(a, b, c, d) } else { e }
}

/// Returns whether the ray passes some edges on one side and some on the other: it misses.
#[inline(always)]
pub(crate) fn have_both_signs<S: Scalar>([u, v, w]: [S; 3]) -> bool {
    (u < S::ZERO || v < S::ZERO || w < S::ZERO) && (u > S::ZERO || v > S::ZERO || w > S::ZERO)
}

/// Parameter at which the ray hits the triangle, if within `[ray.t_min, t_max]`.
#[inline(always)]
pub(crate) fn intersect<S: Scalar>(
    tri: &[[S; 3]; 3],
    ray: &Ray<S>,
    shear: &Shear<S>,
    t_max: S,
) -> Option<S> {
    intersect_in(tri, shear, ray.t_min, t_max, || precise::intersect(tri, ray, shear, t_max))
}

/// The same in the sheared space alone; `precisely` is asked where that does not tell enough.
#[inline(always)]
pub(crate) fn intersect_in<S: Scalar>(
    tri: &[[S; 3]; 3],
    shear: &Shear<S>,
    t_min: S,
    t_max: S,
    precisely: impl FnOnce() -> Option<S>,
) -> Option<S> {
    let a = shear.apply(&tri[0]);
    let b = shear.apply(&tri[1]);
    let c = shear.apply(&tri[2]);
    let u = edge_function(c[0], b[1], c[1], b[0]);
    let v = edge_function(a[0], c[1], a[1], c[0]);
    let w = edge_function(b[0], a[1], b[1], a[0]);
    if have_both_signs([u, v, w]) {
        return None;
    }
    let det = u + v + w;
    let depth = u * a[2] + v * b[2] + w * c[2];
    let t = depth * shear.shear[2] / det;
    let (terms, largest) = (terms(&[a, b, c]), largest(&[a, b, c]));
    // also where the determinant is zero, or NaN; whatever the interval is and whatever was hit
    // before: a triangle has one parameter on a ray
    if !weights_suffice(terms, largest, det, shear.fine)
        || t >= S::ZERO && depth.abs() < shear.near * (largest * largest)
    {
        return precisely();
    }
    // NaN fails both comparisons
    (t >= t_min && t <= t_max).then_some(t)
}
