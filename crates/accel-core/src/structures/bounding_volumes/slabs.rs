//! Slabs: the space between two parallel planes, intersected over a few fixed directions.
//!
//! Paper: T. L. Kay, J. T. Kajiya, "Ray Tracing Complex Scenes", SIGGRAPH 1986. A ray's dot
//! products with the directions are computed once; a slab then costs a subtraction and a
//! multiplication a plane. Deviation: the diagonals are not of unit length, so that a dot product
//! with one is a sum of coordinates; a slab lies where it lies whatever the length of its normal.

use glam::{DVec3, dvec3};

use crate::geometry::aabb::Aabb;
use crate::geometry::ray::Ray;
use crate::geometry::scalar::{Scalar, Vec3, Vector};
use crate::historical::bounds_rule::BoundsOf;
use crate::structures::bounding_volumes::volume::Volume;

/// The axes, then the diagonals of the cube.
const NORMALS: [DVec3; 7] = [
    DVec3::X,
    DVec3::Y,
    DVec3::Z,
    dvec3(1.0, 1.0, 1.0),
    dvec3(1.0, 1.0, -1.0),
    dvec3(1.0, -1.0, 1.0),
    dvec3(-1.0, 1.0, 1.0),
];

/// The plane normals of a volume of `K` slabs: 3 are the axes, 4 the diagonals, 7 all of them.
pub(crate) const fn normals<const K: usize>() -> [DVec3; K] {
    const { assert!(K == 3 || K == 4 || K == 7) };
    let first = if K == 4 { 3 } else { 0 };
    let mut normals = [DVec3::ZERO; K];
    let mut k = 0;
    while k < K {
        normals[k] = NORMALS[first + k];
        k += 1;
    }
    normals
}

/// By how much an interval along `normal` grows, in paddings of a box. On a diagonal the errors of
/// three coordinates add up, and every sum of a point, a ray's origin or direction rounds twice
/// more: together less than twice the sum of the three paddings.
fn paddings(normal: DVec3) -> f64 {
    let nonzero = normal.abs().element_sum();
    if nonzero > 1.0 { 2.0 * nonzero } else { 1.0 }
}

/// The intersection of `K` slabs, as intervals of the dot product with each normal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Slabs<S, const K: usize> {
    intervals: [[S; 2]; K],
}

impl<S: Scalar, const K: usize> Slabs<S, K> {
    /// The volume that holds nothing.
    pub(crate) fn empty() -> Self {
        Self { intervals: [[S::INFINITY, -S::INFINITY]; K] }
    }

    /// The smallest volume around both.
    pub(crate) fn union(mut self, other: &Self) -> Self {
        for (all, new) in self.intervals.iter_mut().zip(&other.intervals) {
            *all = [new[0].lesser(all[0]), new[1].greater(all[1])];
        }
        self
    }
}

/// A ray along one normal.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ProjectedRay<S> {
    /// Dot product of the origin; NaN, which constrains nothing, if a dot product overflows.
    origin: S,
    /// Reciprocal of the dot product of the direction; infinity if that is zero.
    inverse: S,
}

impl<S: Scalar> ProjectedRay<S> {
    #[inline(always)]
    fn new(ray: &Ray<S>, normal: DVec3) -> Self {
        let normal = Vec3::<S>::from_dvec3(normal);
        let (mut origin, step) = (ray.origin.dot(normal), ray.direction.dot(normal));
        if !(origin.is_finite() && step.is_finite()) {
            origin = S::from_f64(f64::NAN);
        }
        Self { origin, inverse: if step == S::ZERO { S::INFINITY } else { S::ONE / step } }
    }

    /// Parameters at which the ray is between the planes. A parallel ray is there always (minus
    /// to plus infinity), or never (both plus or both minus infinity); NaN is no constraint.
    #[inline(always)]
    fn within(&self, [lo, hi]: [S; 2]) -> (S, S) {
        let a = (lo - self.origin) * self.inverse;
        let b = (hi - self.origin) * self.inverse;
        if self.inverse < S::ZERO { (b, a) } else { (a, b) }
    }
}

impl<S: Scalar, const K: usize> Volume<S> for Slabs<S, K> {
    type RaySetup = [ProjectedRay<S>; K];

    fn around(ids: &[u32], boxes: &BoundsOf<S>) -> Self {
        let intervals = normals::<K>().map(|normal| {
            let extents = ids.iter().map(|&id| boxes.prims().extent(id, normal));
            let (lo, hi) = extents.fold((f64::INFINITY, f64::NEG_INFINITY), |all, new| {
                (all.0.min(new.0), all.1.max(new.1))
            });
            let padding = boxes.padding().to_f64() * paddings(normal);
            [S::from_f64(lo - padding), S::from_f64(hi + padding)]
        });
        Self { intervals }
    }

    #[inline(always)]
    fn setup(ray: &Ray<S>) -> Self::RaySetup {
        normals::<K>().map(|normal| ProjectedRay::new(ray, normal))
    }

    #[inline(always)]
    fn entry(&self, ray: &Self::RaySetup, t_min: S, t_max: S) -> Option<S> {
        let (mut t_in, mut t_out) = (t_min, t_max);
        for (interval, along) in self.intervals.iter().zip(ray) {
            let (near, far) = along.within(*interval);
            // greater/lesser keep the old bound when the new one is NaN
            t_in = near.greater(t_in);
            t_out = far.lesser(t_out);
        }
        (t_in <= t_out && t_in < S::INFINITY).then_some(t_in)
    }

    fn bounds(&self) -> Aabb<f64> {
        let at = |i: usize| self.intervals[i].map(S::to_f64);
        // without the axes: half the sum of two diagonals, or their difference, is a coordinate
        let half = |[a, b]: [f64; 2], [c, d]: [f64; 2]| [(a + c) * 0.5, (b + d) * 0.5];
        let on_axis = |k: usize| match K {
            4 => {
                let all = at(0);
                let [x, y, z] = [at(3), at(2), at(1)];
                let others = [half(z, y), half(z, x), half(y, x)][k];
                let own = [x, y, z][k];
                let whole = half(all, [-own[1], -own[0]]);
                [others[0].max(whole[0]), others[1].min(whole[1])]
            }
            _ => at(k),
        };
        let [x, y, z] = [0, 1, 2].map(on_axis);
        Aabb { min: dvec3(x[0], y[0], z[0]), max: dvec3(x[1], y[1], z[1]) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The cube from -1 to 1, or the octahedron |x| + |y| + |z| <= 1, or where both are.
    fn unit<const K: usize>() -> Slabs<f32, K> {
        Slabs { intervals: [[-1.0, 1.0]; K] }
    }

    fn entry<const K: usize>(o: [f32; 3], d: [f32; 3], t_max: f32) -> Option<f32> {
        let ray = Ray::<f32>::new(o.into(), d.into());
        unit::<K>().entry(&Slabs::<f32, K>::setup(&ray), 0.0, t_max)
    }

    #[test]
    fn cube_and_octahedron() {
        let inf = f32::INFINITY;
        assert_eq!(entry::<3>([-3.0, 0.9, 0.9], [1.0, 0.0, -0.0], inf), Some(2.0));
        assert_eq!(entry::<4>([-3.0, 0.0, 0.0], [1.0, 0.0, -0.0], inf), Some(2.0));
        assert_eq!(entry::<4>([-3.0, 0.5, 0.0], [1.0, 0.0, 0.0], inf), Some(2.5));
        assert_eq!(entry::<7>([-3.0, 0.9, 0.9], [1.0, 0.0, 0.0], inf), None);
        assert_eq!(entry::<3>([-3.0, 0.9, 0.9], [1.0, 0.0, 0.0], 1.9), None);
        assert_eq!(entry::<7>([0.1, 0.0, 0.0], [1.0, 2.0, 3.0], inf), Some(0.0));
        assert_eq!(entry::<3>([3.0, 0.0, 0.0], [1.0, 0.0, 0.0], inf), None);
    }

    #[test]
    fn parallel_rays_are_inside_on_or_outside() {
        for (y, met) in [(0.5, true), (1.0, true), (-1.0, true), (1.1, false), (-1.1, false)] {
            for zero in [0.0, -0.0] {
                let t = entry::<3>([-3.0, y, 0.0], [1.0, zero, zero], f32::INFINITY);
                assert_eq!(t, met.then_some(2.0), "y = {y}");
            }
        }
        // along a diagonal plane: the dot product with (1, 1, 1) is zero
        for (z, met) in [(0.5, true), (1.0, true), (1.5, false), (-1.5, false)] {
            let t = entry::<4>([0.0, 0.0, z], [0.25, -0.25, 0.0], f32::INFINITY);
            assert_eq!(t.is_some(), met, "z = {z}");
        }
    }

    #[test]
    fn dot_products_that_overflow_constrain_nothing() {
        assert!(entry::<7>([0.0; 3], [3e38, 3e38, 3e38], 1.0).is_some());
        assert!(entry::<4>([2e38, 2e38, 0.0], [-3e38, -3e38, 0.0], 1.0).is_some());
    }

    #[test]
    fn a_union_contains_both_slabs() {
        let a = Slabs::<f64, 3> { intervals: [[0.0, 1.0], [2.0, 3.0], [-1.0, 0.0]] };
        let b = Slabs::<f64, 3> { intervals: [[-1.0, 0.5], [2.5, 4.0], [5.0, 6.0]] };
        let both = Slabs { intervals: [[-1.0, 1.0], [2.0, 4.0], [-1.0, 6.0]] };
        assert_eq!(Slabs::empty().union(&a).union(&b), both);
    }
}
