//! The watertight triangle test where its scalar does not tell enough: rare, and so out of line.
//!
//! Four cases. **A triangle seen nearly edge-on.** The signs of edge functions are exact (see
//! `triangle.rs`), but where products cancel, what is left of their difference is rounding: weights
//! of nothing, and `t` any parameter between those of the corners, wherever the ray is then. With
//! weights off by `e` each, the ray at `t` passes the triangle's point of these weights at up to `3
//! e m / det`, `m` being the largest coordinate of the sheared corners and `e` at most `epsilon p`,
//! where `p` is the largest sum of the two products of an edge function, without their signs: of a
//! thin triangle along an axis far less than `m^2`. [`weights_suffice`] admits 12 epsilons of the
//! scene's largest coordinate; the padding of boxes (`bounds_rule.rs`) has room for that, and no
//! structure loses the hit. Beyond it, the weights are computed here, off by no more than a few
//! ulps of their own. **A hit so near the origin** that it may lie behind it: with weights off by 2
//! epsilons of `m^2` each, and a sum of three terms off by 1.5 epsilons of the largest depth, depth
//! times `det` is off by 12 epsilons of the largest depth and of `m^2` (`det` is 4 `m^2` at most);
//! nearer than 20, and not behind the origin, the depth is computed here, and its sign is that of
//! the rounded corners' plane. So a box of a triangle that ends behind the origin holds no hit,
//! were it padded for the rounding of corners alone (`bvh/node.rs`). **A ray with a component so
//! small** that sheared corners are subnormal numbers of few digits: everything is computed in f64,
//! from the corners on. **A triangle so small** that its determinant is one: corners are multiplied
//! by powers of two.
//!
//! Differences of products: after W. Kahan's algorithm, see C.-P. Jeannerod, N. Louvet, J.-M.
//! Muller, "Further Analysis of Kahan's Algorithm for the Accurate Computation of 2x2
//! Determinants", Mathematics of Computation 82, 2013; with the rounding errors of both products.

use crate::geometry::ray::Ray;
use crate::geometry::scalar::{Scalar, Vector};
use crate::primitives::shear::Shear;

/// By what sheared coordinates are multiplied where a ray's component is too small: what is
/// subnormal in f64 becomes normal, and no product of two coordinates of a served scene overflows.
const ENLARGED: f64 = f64::from_bits((1023 + 250) << 52);

/// `a*b - c*d`, off by few ulps; exact in sign, and `c*d - a*b` is just its opposite, so that what
/// is mirrored is hit at the same parameter.
#[inline(always)]
fn difference(a: f64, b: f64, c: f64, d: f64) -> f64 {
    let (ab, cd) = (a * b, c * d);
    (ab - cd) + (a.mul_add(b, -ab) - c.mul_add(d, -cd))
}

/// [`difference`], exact in sign where products underflow, too.
pub(super) fn signed_difference(a: f64, b: f64, c: f64, d: f64) -> f64 {
    let e = difference(a, b, c, d);
    let underflows = |product: f64| product.abs() < f64::from_bits((1023 - 900) << 52);
    if e != 0.0 || !underflows(a * b) || !underflows(c * d) {
        return e;
    }
    // one factor of such a product may be large only if the other is zero
    let enlarged = |x: f64| (x * f64::from_bits((1023 + 600) << 52)).clamp(-f64::MAX, f64::MAX);
    let e = difference(enlarged(a), enlarged(b), enlarged(c), enlarged(d));
    if e == 0.0 { e } else { f64::from_bits(1).copysign(e) }
}

/// `a*b - c*d` where both products round to the same number: exact in sign.
#[cold]
#[inline(never)]
pub(super) fn exact_difference<S: Scalar>(a: S, b: S, c: S, d: S) -> S {
    let wide = signed_difference(a.to_f64(), b.to_f64(), c.to_f64(), d.to_f64());
    let e = S::from_f64(wide);
    // the sign of what is too small for the scalar counts, too
    if e != S::ZERO || wide == 0.0 {
        e
    } else if wide > 0.0 {
        S::ZERO.next_up()
    } else {
        S::ZERO.next_down()
    }
}

/// Returns whether the weights of a hit are precise enough in the scalar: `terms` is the largest
/// sum of an edge function's products without signs, `largest` the largest of the sheared corners'
/// coordinates, `fine` that of [`Shear`]. NaN does not suffice.
#[inline(always)]
pub(super) fn weights_suffice<S: Scalar>(terms: S, largest: S, det: S, fine: S) -> bool {
    terms * largest < fine * det.abs() && det.abs() >= S::LEAST_DETERMINANT
}

/// The parameter of the hit if it lies in `[ray.t_min, t_max]`.
#[cold]
#[inline(never)]
pub(super) fn intersect<S: Scalar>(
    tri: &[[S; 3]; 3],
    ray: &Ray<S>,
    shear: &Shear<S>,
    t_max: S,
) -> Option<S> {
    let sheared = ShearedVertices::by(ray, shear);
    let [a, b, c] = of_unit_size(tri.map(|v| sheared.vertex(&v)));
    let u = difference(c[0], b[1], c[1], b[0]);
    let v = difference(a[0], c[1], a[1], c[0]);
    let w = difference(b[0], a[1], b[1], a[0]);
    if (u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0) {
        return None;
    }
    let det = u + v + w;
    if det == 0.0 {
        return None;
    }
    // by a power of two first: products with enlarged edge functions could overflow
    let unit = det.to_unit_size();
    let depth = u * unit * a[2] + v * unit * b[2] + w * unit * c[2];
    let t = S::from_f64(depth * shear.depth_scale().to_f64() / (det * unit));
    // NaN fails both comparisons
    (t >= ray.t_min && t <= t_max).then_some(t)
}

/// Corners whose coordinates across the ray are multiplied by powers of two: products of small
/// ones do not underflow.
fn of_unit_size(corners: [[f64; 3]; 3]) -> [[f64; 3]; 3] {
    let unit = |k: usize| corners.iter().fold(0.0, |m: f64, p| m.max(p[k].abs())).to_unit_size();
    let units = [unit(0), unit(1)];
    corners.map(|[x, y, z]| [x * units[0], y * units[1], z])
}

/// Vertices in the sheared space, in f64: what the scalar rounds them to. Where a component of the
/// ray is too small for that, coordinates across the ray are computed in f64, and enlarged along
/// that component.
pub(super) struct ShearedVertices<'a, S: Scalar> {
    shear: &'a Shear<S>,
    /// Components too small for the scalar.
    fine: Option<EnlargedRay>,
}

struct EnlargedRay {
    origin: [f64; 3],
    factors: [f64; 2],
    slopes: [f64; 2],
}

impl<'a, S: Scalar> ShearedVertices<'a, S> {
    /// How this ray, of that shear, sees vertices.
    pub(super) fn by(ray: &Ray<S>, shear: &'a Shear<S>) -> Self {
        let fine = shear.is_too_small().then(|| {
            let [kx, ky, kz] = shear.axes;
            let (o, d) = (ray.origin.to_dvec3(), ray.direction.to_dvec3());
            let least = S::LEAST_SLOPE.to_f64();
            let factor = |k: usize| if (d[k] / d[kz]).abs() < least { ENLARGED } else { 1.0 };
            let factors = [factor(kx), factor(ky)];
            let slopes = [d[kx] * factors[0] / d[kz], d[ky] * factors[1] / d[kz]];
            EnlargedRay { origin: shear.axes.map(|k| o[k]), factors, slopes }
        });
        Self { shear, fine }
    }

    /// A vertex; its depth is still to be scaled by [`Shear::depth_scale`].
    pub(super) fn vertex(&self, v: &[S; 3]) -> [f64; 3] {
        let Some(EnlargedRay { origin, factors, slopes }) = &self.fine else {
            return self.shear.apply(v).map(S::to_f64);
        };
        let [kx, ky, kz] = self.shear.axes;
        let [x, y, z] = [(kx, 0), (ky, 1), (kz, 2)].map(|(k, i)| v[k].to_f64() - origin[i]);
        [x * factors[0] - slopes[0] * z, y * factors[1] - slopes[1] * z, z]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn differences_are_those_of_the_products() {
        let (up, down) = (1.0f64.next_up(), 1.0f64.next_down());
        // the product less one, and what rounding took from it
        assert_eq!(
            difference(up, down, 1.0, 1.0),
            up * down - 1.0 + up.mul_add(down, -(up * down))
        );
        assert_eq!(difference(up, up, up, up), 0.0);
        let (a, b, c, d) = (0.1, 0.7, 0.3, 0.2);
        assert_eq!(difference(a, b, c, d), -difference(c, d, a, b));
        assert_eq!(exact_difference(up, down, down, up), 0.0);
        assert!(exact_difference(up, up, 1.0, up.next_up()) > 0.0);
        assert!(exact_difference(1.0, up.next_up(), up, up) < 0.0);
    }

    #[test]
    fn differences_that_underflow_keep_their_sign() {
        let (a, b) = (1e-30f32, 2e-30f32);
        assert_eq!(b * b - a * a, 0.0);
        assert!(exact_difference(b, b, a, a) > 0.0);
        assert!(exact_difference(a, a, b, b) < 0.0);
        assert_eq!(exact_difference(a, b, b, a), 0.0);
        let (a, b, up) = (1e-170f64, 1e-170f64.next_up(), 1.0f64.next_up());
        assert_eq!(b * b - a * a, 0.0);
        assert!(exact_difference(b, b, a, a) > 0.0 && exact_difference(a, a, b, b) < 0.0);
        assert!(exact_difference(a, 1e-170, 1e300, 0.0) > 0.0);
        assert_eq!(exact_difference(a, b, b, a), 0.0);
        // planted fault: products that underflow have no sign without being enlarged
        assert_eq!(difference(b, b, a, a), 0.0);
        let (least, half) = (f64::from_bits(1), 0.5);
        assert!(exact_difference(least, half * up, least, half) > 0.0);
    }
}
