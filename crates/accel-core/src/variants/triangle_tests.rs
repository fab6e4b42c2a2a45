//! Other tests of triangles, to be compared with the watertight one: what they lose, what they
//! cost.
//!
//! Papers: T. Moeller, B. Trumbore, "Fast, Minimum Storage Ray/Triangle Intersection", JGT 2(1),
//! 1997 (with a tolerance, as it is often used); K. Shoemake, "Pluecker Coordinate Tutorial", Ray
//! Tracing News 11(1), 1998 (signs of the ray against each edge); S. Woop, C. Benthin, I. Wald,
//! "Watertight Ray/Triangle Intersection", JCGT 2(1), 2013 (double precision where an edge function
//! is zero).
//!
//! Deviations: coordinates of the Pluecker test are relative to the ray's origin, so that only the
//! moment of each edge is left; the test in f64 is the watertight one on the same vertices.

use crate::geometry::ray::Ray;
use crate::geometry::scalar::{Scalar, Vec3, Vector};
use crate::primitives::watertight::{edge_function, have_both_signs};
use crate::primitives::{
    MoellerTrumboreWithin, Shear, TriangleBlock, TriangleTest, Watertight, block_tests,
};

/// Moeller and Trumbore 1997 with a tolerance, as it is often used: triangles are a little larger
/// than they are. 10^-6 in f32.
pub type MoellerTrumboreTolerant = MoellerTrumboreWithin<8>;

/// On which side of each edge the ray passes, by Pluecker coordinates.
#[derive(Debug, Clone, Copy)]
pub struct Pluecker;

impl<S: Scalar> TriangleTest<S> for Pluecker {
    type Setup = ();

    #[inline(always)]
    fn setup(_: &Ray<S>, _: S) {}

    #[inline(always)]
    fn intersect(tri: &[[S; 3]; 3], ray: &Ray<S>, _: &(), t_max: S) -> Option<S> {
        let [a, b, c] = tri.map(|v| Vec3::<S>::from_array(v) - ray.origin);
        let d = ray.direction;
        let (u, v, w) = (d.dot(c.cross(b)), d.dot(a.cross(c)), d.dot(b.cross(a)));
        if have_both_signs([u, v, w]) {
            return None;
        }
        let normal = (b - a).cross(c - a);
        let det = d.dot(normal);
        if det == S::ZERO {
            return None;
        }
        let t = a.dot(normal) / det;
        (t >= ray.t_min && t <= t_max).then_some(t)
    }

    #[inline(always)]
    fn hits_in_block(
        block: &TriangleBlock<S>,
        ray: &Ray<S>,
        _: &Self::Setup,
        t_max: S,
    ) -> Option<(u32, [S; 8])> {
        Some(block_tests::pluecker(block, ray, t_max))
    }
}

/// The watertight test as published: where an edge function rounds to zero, all three are computed
/// again in f64.
#[derive(Debug, Clone, Copy)]
pub struct WatertightFallback;

impl<S: Scalar> TriangleTest<S> for WatertightFallback {
    type Setup = Shear<S>;

    #[inline(always)]
    fn setup(ray: &Ray<S>, magnitude: S) -> Shear<S> {
        Shear::of_any(ray, magnitude)
    }

    #[inline(always)]
    fn intersect(tri: &[[S; 3]; 3], ray: &Ray<S>, shear: &Shear<S>, t_max: S) -> Option<S> {
        let [a, b, c] = tri.each_ref().map(|v| shear.apply(v));
        let [mut u, mut v, mut w] =
            [c[0] * b[1] - c[1] * b[0], a[0] * c[1] - a[1] * c[0], b[0] * a[1] - b[1] * a[0]];
        if u == S::ZERO || v == S::ZERO || w == S::ZERO {
            [u, v, w] = in_double([a, b, c]);
        }
        if have_both_signs([u, v, w]) {
            return None;
        }
        let det = u + v + w;
        if det == S::ZERO {
            return None;
        }
        let t = (u * a[2] + v * b[2] + w * c[2]) * shear.depth_scale() / det;
        (t >= ray.t_min && t <= t_max).then_some(t)
    }

    #[inline(always)]
    fn hits_in_block(
        block: &TriangleBlock<S>,
        ray: &Ray<S>,
        shear: &Self::Setup,
        t_max: S,
    ) -> Option<(u32, [S; 8])> {
        Some(block_tests::watertight_fallback(block, ray, shear, t_max, |triangle| {
            Self::intersect(triangle, ray, shear, t_max)
        }))
    }
}

#[cold]
#[inline(never)]
fn in_double<S: Scalar>(corners: [[S; 3]; 3]) -> [S; 3] {
    let [a, b, c] = corners.map(|p| p.map(S::to_f64));
    let of = |p: [f64; 3], q: [f64; 3]| S::from_f64(edge_function(p[0], q[1], p[1], q[0]));
    [of(c, b), of(a, c), of(b, a)]
}

/// The watertight test in f64, of the same vertices and the same ray.
#[derive(Debug, Clone, Copy)]
pub struct WatertightInDouble;

impl<S: Scalar> TriangleTest<S> for WatertightInDouble {
    type Setup = (Ray<f64>, Shear<f64>);

    #[inline(always)]
    fn setup(ray: &Ray<S>, magnitude: S) -> Self::Setup {
        let ray = ray.widened();
        (ray, Shear::of(&ray, magnitude.to_f64()))
    }

    #[inline(always)]
    fn intersect(tri: &[[S; 3]; 3], _: &Ray<S>, (ray, shear): &Self::Setup, t_max: S) -> Option<S> {
        let wide = tri.map(|v| v.map(S::to_f64));
        let t = S::from_f64(Watertight::intersect(&wide, ray, shear, t_max.to_f64())?);
        // rounding must not carry it beyond the end that the caller compares with
        (t <= t_max).then_some(t)
    }

    #[inline(always)]
    fn hits_in_block(
        block: &TriangleBlock<S>,
        _: &Ray<S>,
        (ray, shear): &Self::Setup,
        t_max: S,
    ) -> Option<(u32, [S; 8])> {
        let (mut lanes, t) = block.widened().hits(ray, shear, t_max.to_f64())?;
        let t = t.map(S::from_f64);
        for (lane, t) in t.iter().enumerate() {
            lanes &= !(u32::from(*t > t_max) << lane);
        }
        Some((lanes, t))
    }
}

#[cfg(test)]
mod tests {
    use std::any::type_name;

    use glam::dvec3;

    use super::*;
    use crate::primitives::MoellerTrumbore;
    use crate::primitives::triangle_block::tests::{agreed, ray_to_3};
    use crate::structures::test_scenes::Random;

    /// Every test finds the middle of a triangle from both sides, and passes by what is beside it.
    fn finds<S: Scalar, T: TriangleTest<S>>() {
        let corner = |x: f64, y: f64| [x, y, 1.0].map(S::from_f64);
        let tri = [corner(0.0, 0.0), corner(1.0, 0.0), corner(0.0, 1.0)];
        for side in [1.0, -1.0] {
            let at = |x: f64, y: f64| {
                let ray = Ray::<S>::from_dvec3(dvec3(x, y, 1.0 - side), dvec3(0.0, 0.0, side));
                T::intersect(&tri, &ray, &T::setup(&ray, S::ONE), S::from_f64(9.0)).map(S::to_f64)
            };
            assert_eq!(at(0.25, 0.25), Some(1.0), "{}", type_name::<T>());
            assert_eq!(at(0.75, 0.75), None, "{}", type_name::<T>());
            assert_eq!(at(-0.25, 0.25), None, "{}", type_name::<T>());
        }
    }

    #[test]
    fn they_find_what_is_there() {
        finds::<f32, MoellerTrumboreTolerant>();
        finds::<f32, Pluecker>();
        finds::<f32, WatertightFallback>();
        finds::<f32, WatertightInDouble>();
        finds::<f64, WatertightFallback>();
        finds::<f64, WatertightInDouble>();
    }

    /// On a coarse lattice, where edges are met exactly, and off it.
    fn blocks_agree<S: Scalar, T: TriangleTest<S>>() {
        let mut random = Random(11);
        let mut point =
            |cells: f64| [0; 3].map(|_| S::from_f64((random.unit() * cells).floor() / cells));
        let mut hits = 0;
        for round in 0..3000 {
            let cells = if round % 2 == 0 { 4.0 } else { 1e6 };
            let triangles = [0; 5].map(|_| [0; 3].map(|_| point(cells)));
            let (from, to) = (point(cells), point(cells));
            let d: [S; 3] = std::array::from_fn(|k| to[k] - from[k]);
            if d == [S::ZERO; 3] {
                continue;
            }
            let ray = ray_to_3(from, d);
            let numbered = || triangles.iter().zip(7..).map(|(t, id)| (id, *t));
            let block = TriangleBlock::new(numbered(), false);
            let best = agreed::<S, T>(&block, numbered(), &ray, &T::setup(&ray, S::ONE));
            hits += usize::from(best.is_hit());
        }
        assert!(hits > 200, "{} {hits}", type_name::<T>());
    }

    #[test]
    fn eight_at_once_are_one_after_the_other() {
        blocks_agree::<f32, MoellerTrumbore>();
        blocks_agree::<f64, MoellerTrumbore>();
        blocks_agree::<f32, MoellerTrumboreTolerant>();
        blocks_agree::<f32, Pluecker>();
        blocks_agree::<f64, Pluecker>();
        blocks_agree::<f32, WatertightFallback>();
        blocks_agree::<f64, WatertightFallback>();
        blocks_agree::<f32, WatertightInDouble>();
    }
}
