//! Triangles: the watertight test (the default) and Moeller-Trumbore beside it.
//!
//! Papers: S. Woop, C. Benthin, I. Wald, "Watertight Ray/Triangle Intersection", JCGT 2(1), 2013;
//! T. Moeller, B. Trumbore, "Fast, Minimum Storage Ray/Triangle Intersection", JGT 2(1), 1997.
//!
//! Deviations from Woop et al.: both sides are hit; where an edge function rounds to zero its
//! exact sign is found by error-free products instead of double precision, so f64 is watertight
//! too; the division is done before the interval test, which is closed; triangles seen nearly
//! edge-on, and rays with a component too small to divide by, are left to `precise.rs`.

use std::marker::PhantomData;

use glam::DVec3;

use crate::geometry::aabb::Aabb;
use crate::geometry::ray::{Hit, Ray};
use crate::geometry::ray_lanes::{LANES, RayLanes};
use crate::geometry::scalar::{Scalar, Vec3, Vector};
use crate::memory::prefetch;
use crate::primitives::block_tests;
use crate::primitives::collinear::without_sliver;
use crate::primitives::shear::Shear;
use crate::primitives::shear_lanes::ShearLanes;
use crate::primitives::support::{Ball, balls_around, distance_to_points, extent_of_points};
use crate::primitives::triangle_block::TriangleBlock;
use crate::primitives::watertight;
use crate::primitives::{
    IdSet, Instance, Instances, PrimSet, PrimitiveError, PrimitiveKind, Primitives,
};

/// A way to intersect a ray with a triangle.
pub trait TriangleTest<S: Scalar>: Send + Sync + 'static {
    type Setup: Copy;
    /// True for the test of all sets, with which others are compared.
    const IS_DEFAULT: bool = false;
    /// Prepares a ray for triangles of which no coordinate is larger than `magnitude`.
    fn setup(ray: &Ray<S>, magnitude: S) -> Self::Setup;
    /// The same where the ray's shear is known: the watertight test does not compute it twice.
    #[inline(always)]
    fn setup_beside(ray: &Ray<S>, magnitude: S, _shear: &Shear<S>) -> Self::Setup {
        Self::setup(ray, magnitude)
    }
    /// Prepares eight rays, which `lanes` holds too: what [`TriangleTest::setup`] says of each, by
    /// lane.
    #[inline(always)]
    fn setups(
        rays: &[Ray<S>; LANES],
        _lanes: &RayLanes<S>,
        magnitude: S,
    ) -> impl Fn(usize) -> Self::Setup {
        move |lane| Self::setup(&rays[lane], magnitude)
    }
    /// The parameter of the hit if it lies in `[ray.t_min, t_max]`.
    fn intersect(v: &[[S; 3]; 3], ray: &Ray<S>, setup: &Self::Setup, t_max: S) -> Option<S>;
    /// Lanes of a block whose triangles are hit so, with their parameters; `None` or no lanes where
    /// none is.
    fn hits_in_block(
        block: &TriangleBlock<S>,
        ray: &Ray<S>,
        setup: &Self::Setup,
        t_max: S,
    ) -> Option<(u32, [S; 8])>;
    /// Replaces `best` by a closer hit of a triangle of the block, or by an equal one of a lower
    /// id.
    #[inline(always)]
    fn closest_in_block(
        block: &TriangleBlock<S>,
        ray: &Ray<S>,
        setup: &Self::Setup,
        best: &mut Hit<S>,
    ) {
        if let Some((lanes, t)) = Self::hits_in_block(block, ray, setup, best.t) {
            block.take_closest(lanes, &t, best);
        }
    }
    /// Returns whether the ray meets a triangle of the block of which `counts` holds.
    #[inline(always)]
    fn any_in_block(
        block: &TriangleBlock<S>,
        ray: &Ray<S>,
        setup: &Self::Setup,
        counts: impl Fn(u32) -> bool,
    ) -> bool {
        let hits = Self::hits_in_block(block, ray, setup, ray.t_max);
        hits.is_some_and(|(lanes, _)| block.any_of(lanes, counts))
    }
}

/// Woop, Benthin and Wald 2013: no ray slips between two triangles that share an edge or vertex.
#[derive(Debug, Clone, Copy)]
pub struct Watertight;

impl<S: Scalar> TriangleTest<S> for Watertight {
    type Setup = Shear<S>;
    const IS_DEFAULT: bool = true;

    #[inline(always)]
    fn setup(ray: &Ray<S>, magnitude: S) -> Shear<S> {
        Shear::of(ray, magnitude)
    }

    #[inline(always)]
    fn setup_beside(_: &Ray<S>, _: S, shear: &Shear<S>) -> Shear<S> {
        *shear
    }

    #[inline(always)]
    fn setups(
        rays: &[Ray<S>; LANES],
        lanes: &RayLanes<S>,
        magnitude: S,
    ) -> impl Fn(usize) -> Shear<S> {
        let shears = ShearLanes::of(rays, lanes, magnitude);
        move |lane| shears.get(lane)
    }

    #[inline(always)]
    fn intersect(tri: &[[S; 3]; 3], ray: &Ray<S>, shear: &Shear<S>, t_max: S) -> Option<S> {
        watertight::intersect(tri, ray, shear, t_max)
    }

    #[inline(always)]
    fn hits_in_block(
        block: &TriangleBlock<S>,
        ray: &Ray<S>,
        shear: &Shear<S>,
        t_max: S,
    ) -> Option<(u32, [S; 8])> {
        block.hits(ray, shear, t_max)
    }
}

/// Moeller and Trumbore 1997, both sides, no epsilon: faster on some machines, leaks at edges.
pub type MoellerTrumbore = MoellerTrumboreWithin<0>;

/// The same with hits accepted up to so many epsilons of the scalar outside, in barycentric
/// coordinates.
#[derive(Debug, Clone, Copy)]
pub struct MoellerTrumboreWithin<const EPSILONS: i32>;

impl<S: Scalar, const EPSILONS: i32> TriangleTest<S> for MoellerTrumboreWithin<EPSILONS> {
    type Setup = ();

    #[inline(always)]
    fn setup(_: &Ray<S>, _: S) {}

    #[inline(always)]
    fn intersect(tri: &[[S; 3]; 3], ray: &Ray<S>, _: &(), t_max: S) -> Option<S> {
        let tolerance = S::EPSILON * S::from_i32(EPSILONS);
        let [v0, v1, v2] = tri.map(Vec3::<S>::from_array);
        let (e1, e2) = (v1 - v0, v2 - v0);
        let p = ray.direction.cross(e2);
        let det = e1.dot(p);
        if det == S::ZERO {
            return None;
        }
        let inv = S::ONE / det;
        let s = ray.origin - v0;
        let u = s.dot(p) * inv;
        let q = s.cross(e1);
        let v = ray.direction.dot(q) * inv;
        if !(u >= -tolerance && v >= -tolerance && u + v <= S::ONE + tolerance) {
            return None;
        }
        let t = e2.dot(q) * inv;
        (t >= ray.t_min && t <= t_max).then_some(t)
    }

    #[inline(always)]
    fn hits_in_block(
        block: &TriangleBlock<S>,
        ray: &Ray<S>,
        _: &(),
        t_max: S,
    ) -> Option<(u32, [S; 8])> {
        let tolerance = S::EPSILON * S::from_i32(EPSILONS);
        Some(block_tests::moeller_trumbore(block, ray, t_max, tolerance))
    }
}

/// Triangles alone, tested by `T`. 36 bytes per triangle in f32, 72 in f64.
#[derive(Debug, Clone)]
#[repr(C)]
pub struct TriangleSet<S: Scalar, T: TriangleTest<S> = Watertight> {
    triangles: Vec<[[S; 3]; 3]>,
    transmissive: IdSet,
    magnitude: S,
    instances: Instances,
    test: PhantomData<T>,
}

impl<S: Scalar, T: TriangleTest<S>> TriangleSet<S, T> {
    /// From vertex triples; ids follow the order given. `is_transmissive(id)` marks the triangles
    /// that let shadow rays pass. Triangles without area are kept, and never hit.
    ///
    /// # Errors
    /// [`PrimitiveError::NotFinite`] for the first triangle with a NaN or infinite coordinate.
    pub fn new(
        triangles: Vec<[[S; 3]; 3]>,
        is_transmissive: impl Fn(u32) -> bool,
    ) -> Result<Self, PrimitiveError> {
        if let Some(id) =
            triangles.iter().position(|t| !t.as_flattened().iter().all(|x| x.is_finite()))
        {
            return Err(PrimitiveError::NotFinite { id: id as u32 });
        }
        let triangles: Vec<_> = triangles.into_iter().map(without_sliver).collect();
        let mut transmissive = IdSet::default();
        (0..triangles.len() as u32)
            .filter(|&id| is_transmissive(id))
            .for_each(|id| transmissive.insert(id));
        let coordinates = triangles.as_flattened().as_flattened();
        let magnitude = coordinates.iter().fold(S::ZERO, |m, x| m.greater(x.abs()));
        let instances = Instances::default();
        Ok(Self { triangles, transmissive, magnitude, instances, test: PhantomData })
    }

    /// The same set, which knows its copies: those of the claims that hold
    /// ([`Instances::confirmed`]).
    #[must_use]
    pub fn with_instances(mut self, claims: &[Instance]) -> Self {
        self.instances = Instances::confirmed(&self, claims);
        self
    }

    /// Forgets those of its parts that are not rigid: that are not where the transform between
    /// their placements takes them from `before`, a set of the same primitives.
    pub fn keep_rigid(&mut self, before: &Self) {
        self.instances.parts = self.instances.rigid_parts(self, before);
    }

    /// The same triangles under another test; nothing is copied.
    pub fn tested_by<U: TriangleTest<S>>(&self) -> &TriangleSet<S, U> {
        // SAFETY: `repr(C)` lays both types out by the same fields, `PhantomData` of no size apart
        unsafe { &*std::ptr::from_ref(self).cast::<TriangleSet<S, U>>() }
    }

    /// The vertices, by id.
    pub fn triangles(&self) -> &[[[S; 3]; 3]] {
        &self.triangles
    }
}

/// Asks for both ends of a triangle's memory, which may lie in two cache lines.
#[inline(always)]
pub(super) fn prefetch_triangle<S>([first, _, last]: &[[S; 3]; 3]) {
    prefetch(first);
    prefetch(last);
}

impl<S: Scalar, T: TriangleTest<S>> Primitives<S> for TriangleSet<S, T> {
    #[inline(always)]
    fn len(&self) -> usize {
        self.triangles.len()
    }

    #[inline(always)]
    fn bounds(&self, id: u32) -> Aabb<S> {
        Aabb::of_triangle(&self.triangles[id as usize].map(Vec3::<S>::from_array))
    }

    fn extent(&self, id: u32, direction: DVec3) -> (f64, f64) {
        extent_of_points(&self.triangles[id as usize], direction)
    }

    fn farthest(&self, id: u32, from: DVec3) -> f64 {
        distance_to_points(&self.triangles[id as usize], from)
    }

    fn hull(&self, id: u32, balls: &mut Vec<Ball>) {
        balls_around(&self.triangles[id as usize], 0.0, balls);
    }

    fn triangles(&self) -> Option<&[[[S; 3]; 3]]> {
        Some(&self.triangles)
    }
    fn corners(&self, id: u32) -> Option<[Vec3<S>; 3]> {
        Some(self.triangles[id as usize].map(Vec3::<S>::from_array))
    }

    fn is_watertight(&self) -> bool {
        T::IS_DEFAULT
    }

    fn kind(&self, _: u32) -> PrimitiveKind {
        PrimitiveKind::Triangle
    }

    fn instances(&self) -> Option<&Instances> {
        Some(&self.instances)
    }

    #[inline(always)]
    fn is_opaque(&self, id: u32) -> bool {
        !self.transmissive.contains(id)
    }

    fn magnitude(&self) -> S {
        self.magnitude
    }

    fn bytes(&self) -> usize {
        size_of_val(self.triangles.as_slice()) + self.transmissive.bytes() + self.instances.bytes()
    }
}

impl<S: Scalar, T: TriangleTest<S>> PrimSet<S> for TriangleSet<S, T> {
    type RaySetup = T::Setup;

    const HAS_BLOCKS: bool = true;

    const HAS_OTHER_TESTS: bool = !T::IS_DEFAULT;

    #[inline(always)]
    fn setup(&self, ray: &Ray<S>) -> T::Setup {
        T::setup(ray, self.magnitude)
    }

    #[inline(always)]
    fn setups(&self, rays: &[Ray<S>; LANES], lanes: &RayLanes<S>) -> impl Fn(usize) -> T::Setup {
        T::setups(rays, lanes, self.magnitude)
    }

    #[inline(always)]
    fn prefetch(&self, id: u32) {
        prefetch_triangle(&self.triangles[id as usize]);
    }
    #[inline(always)]
    fn intersect(&self, id: u32, ray: &Ray<S>, setup: &T::Setup, t_max: S) -> Option<S> {
        T::intersect(&self.triangles[id as usize], ray, setup, t_max)
    }

    #[inline(always)]
    fn closest_in_block(
        &self,
        block: &TriangleBlock<S>,
        ray: &Ray<S>,
        setup: &T::Setup,
        best: &mut Hit<S>,
    ) {
        T::closest_in_block(block, ray, setup, best);
    }

    #[inline(always)]
    fn is_blocked_in(&self, block: &TriangleBlock<S>, ray: &Ray<S>, setup: &T::Setup) -> bool {
        T::any_in_block(block, ray, setup, |id| self.is_opaque(id))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lattice<S: Scalar>(n: i32) -> Vec<[[S; 3]; 3]> {
        let p = |x: i32, y: i32| {
            let z = f64::from((x * 7 + y * 13) % 5) * 0.002;
            [S::from_f64(f64::from(x) * 0.1), S::from_f64(f64::from(y) * 0.1), S::from_f64(z)]
        };
        let mut out = Vec::new();
        for y in 0..n {
            for x in 0..n {
                out.push([p(x, y), p(x + 1, y), p(x + 1, y + 1)]);
                out.push([p(x, y), p(x + 1, y + 1), p(x, y + 1)]);
            }
        }
        out
    }

    /// Rays aimed at inner vertices and edge midpoints of a bumpy lattice; returns the misses.
    fn misses<S: Scalar, T: TriangleTest<S>>() -> usize {
        let tris = lattice::<S>(16);
        let eyes = [[0.83, 0.41, 3.0], [-2.0, 0.3, 1.0], [0.77, 0.9, -2.0], [5.0, 6.0, 7.0]];
        let mut misses = 0;
        for eye in eyes {
            let origin = Vec3::<S>::from_array(eye.map(S::from_f64));
            for t in &tris {
                for k in 0..3 {
                    let a = Vec3::<S>::from_array(t[k]);
                    let b = Vec3::<S>::from_array(t[(k + 1) % 3]);
                    for s in [0.0, 0.5, 0.37] {
                        let target = a + (b - a) * S::from_f64(s);
                        let inner = target.to_array().map(S::to_f64);
                        if inner[..2].iter().any(|&x| !(0.05..=1.55).contains(&x)) {
                            continue;
                        }
                        let ray = Ray::<S>::new(origin, target - origin);
                        let setup = T::setup(&ray, S::from_f64(2.0));
                        let hit = tris
                            .iter()
                            .any(|t| T::intersect(t, &ray, &setup, S::INFINITY).is_some());
                        misses += usize::from(!hit);
                    }
                }
            }
        }
        misses
    }

    #[test]
    fn watertight_has_no_holes_and_moeller_trumbore_does() {
        assert_eq!(misses::<f32, Watertight>(), 0);
        assert_eq!(misses::<f64, Watertight>(), 0);
        // the negative control: without it the aim of the test would prove nothing
        assert!(misses::<f32, MoellerTrumbore>() > 0);
    }

    #[test]
    fn interval_is_closed_and_both_sides_are_hit() {
        let tri = [[0.0f32, 0.0, 1.0], [1.0, 0.0, 1.0], [0.0, 1.0, 1.0]];
        for d in [1.0f32, -1.0] {
            let mut ray = Ray::<f32>::new(glam::vec3(0.2, 0.2, 1.0 - d), glam::vec3(0.0, 0.0, d));
            for (lo, hi, expected) in
                [(0.0, 1.0, true), (1.0, 2.0, true), (0.0, 0.99, false), (1.01, 2.0, false)]
            {
                ray.t_min = lo;
                let w = Watertight::intersect(&tri, &ray, &Shear::of(&ray, 1.0), hi);
                let m = MoellerTrumbore::intersect(&tri, &ray, &(), hi);
                assert_eq!(w, expected.then_some(1.0));
                assert_eq!(m, expected.then_some(1.0));
            }
        }
    }

    #[test]
    fn degenerate_triangles_are_never_hit() {
        // three distinct corners on a slanted line, which shearing rounds into a sliver
        let corner = |k: f32| [0.1 * k, -0.7 * k, 0.3 * k];
        let slanted = [1.0, 2.0, 4.0].map(corner);
        let set = TriangleSet::<f32>::new(vec![slanted], |_| false).unwrap();
        for i in 0..2000 {
            let from = [0.37, 2.9, -1.3].map(|x| x * (1.0 + i as f32 * 0.001));
            let target = corner(1.0 + 3.0 * i as f32 / 2000.0);
            let d = glam::Vec3::from_array(target) - glam::Vec3::from_array(from);
            let ray = Ray::<f32>::new(from.into(), d);
            assert_eq!(set.intersect(0, &ray, &set.setup(&ray), 9.0), None, "ray {i}");
        }
        let p = [0.25f32, 0.5, 1.0];
        let q = [0.75f32, 0.5, 1.0];
        for tri in [[p, p, p], [p, q, p], [p, q, [0.5, 0.5, 1.0]]] {
            for x in [0.25f32, 0.5, 0.75] {
                let ray = Ray::<f32>::new(glam::vec3(x, 0.5, 0.0), glam::vec3(0.0, 0.0, 1.0));
                assert_eq!(Watertight::intersect(&tri, &ray, &Shear::of(&ray, 1.0), 9.0), None);
            }
        }
    }
}
