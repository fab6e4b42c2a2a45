//! Triangles, polygons, spheres and cones under one id space, in file order. They may move: see
//! [`crate::primitives::moving`].

pub(super) mod builder;

use crate::geometry::aabb::Aabb;
use crate::geometry::ray::Ray;
use crate::geometry::scalar::{Scalar, Vec3, Vector};
use crate::historical::bounds_rule::PADDING_ULPS;
use crate::primitives::motion::Motion;
use crate::primitives::polygon::Polygon;
use crate::primitives::prim_set::TaggedIndex;
use crate::primitives::shear::Shear;
use crate::primitives::sphere::{RearrangedSphere, SphereTest};
use crate::primitives::support::{Ball, balls_around, distance_to_points, extent_of_points};
use crate::primitives::triangle::{TriangleTest, Watertight};
use crate::primitives::{
    Cone, IdSet, Instance, Instances, PrimSet, PrimitiveKind, Primitives, Sphere, precise,
    watertight,
};
use glam::DVec3;

/// Per-ray data for tests of moving sets.
#[derive(Debug, Clone, Copy)]
pub struct MovingSetup<S: Scalar> {
    pub(crate) shear: Shear<S>,
    pub(crate) moment: S,
    /// The shear where most primitives see the ray.
    pub(crate) usual: Shear<S>,
    /// Squared length of its direction.
    pub(crate) squared_length: S,
}

/// Primitives of any kind. Built by [`MixedSetBuilder`](super::MixedSetBuilder).
#[derive(Debug, Clone, Default)]
pub struct MixedSet<S: Scalar> {
    order: Vec<TaggedIndex>,
    triangles: Vec<[[S; 3]; 3]>,
    polygons: Vec<Polygon<S>>,
    polygon_vertices: Vec<[S; 3]>,
    spheres: Vec<Sphere<S>>,
    cones: Vec<Cone<S>>,
    transmissive: IdSet,
    magnitude: S,
    motion: Motion<S>,
    /// The spheres where anything moves, each with its velocity (and a zero): one look-up per test.
    moving_spheres: Vec<(Sphere<S>, [S; 4])>,
    instances: Instances,
}

impl<S: Scalar> MixedSet<S> {
    /// The same set, which knows its copies: those of the claims that hold
    /// ([`Instances::confirmed`]); none where anything moves.
    #[must_use]
    pub fn with_instances(mut self, claims: &[Instance]) -> Self {
        if !self.has_motion() {
            self.instances = Instances::confirmed(&self, claims);
        }
        self
    }

    /// Forgets those of its parts that are not rigid: that are not where the transform between
    /// their placements takes them from `before`, a set of the same primitives.
    pub fn keep_rigid(&mut self, before: &Self) {
        self.instances.parts = self.instances.rigid_parts(self, before);
    }

    /// Returns whether any primitive moves.
    pub fn has_motion(&self) -> bool {
        self.motion.any()
    }

    /// The corners of a primitive that is a triangle, where it is at time 0.
    fn triangle(&self, id: u32) -> Option<[Vec3<S>; 3]> {
        let tagged = self.order[id as usize];
        let is_triangle = tagged.kind() == PrimitiveKind::Triangle;
        is_triangle.then(|| self.triangles[tagged.index()].map(Vec3::<S>::from_array))
    }

    /// The parameter of the hit of primitive `id`, triangles tested by `T` and spheres by `Q`.
    #[inline(always)]
    pub(crate) fn tested<T: TriangleTest<S>, Q: SphereTest<S>>(
        &self,
        id: u32,
        ray: &Ray<S>,
        shear: &Shear<S>,
        setup: &T::Setup,
        t_max: S,
    ) -> Option<S> {
        let tagged = self.order[id as usize];
        let i = tagged.index();
        match tagged.kind() {
            PrimitiveKind::Triangle => T::intersect(&self.triangles[i], ray, setup, t_max),
            PrimitiveKind::Polygon => {
                self.polygons[i].intersect(&self.polygon_vertices, ray, shear, t_max)
            }
            PrimitiveKind::Sphere => Q::intersect(&self.spheres[i], ray, t_max),
            PrimitiveKind::Cone => self.cones[i].intersect(ray, t_max),
        }
    }

    fn spheres_with_velocities(&self) -> Vec<(Sphere<S>, [S; 4])> {
        let spheres = (0..).zip(&self.order).filter(|(_, t)| t.kind() == PrimitiveKind::Sphere);
        let moving = |(id, tagged): (u32, &TaggedIndex)| {
            let [x, y, z] = *self.motion.velocity_or_zero(id);
            (self.spheres[tagged.index()], [x, y, z, S::ZERO])
        };
        spheres.map(moving).collect()
    }

    /// The parameter of the hit of primitive `id` where it is at the moment; `setup` is of the ray.
    /// At rest, or at time 0, it is that of the primitive as it stands, to the bit.
    #[inline(always)]
    pub(crate) fn intersect_moved(
        &self,
        id: u32,
        ray: &Ray<S>,
        setup: &MovingSetup<S>,
        t_max: S,
    ) -> Option<S> {
        let tagged = self.order[id as usize];
        let i = tagged.index();
        // each kind computes no more than its test needs, and what is rare anew: nothing is kept in
        // memory
        if tagged.kind() == PrimitiveKind::Sphere {
            let a = setup.squared_length;
            // none where nothing moves
            let Some((sphere, [x, y, z, _])) = self.moving_spheres.get(i) else {
                return self.spheres[i].intersect_from(ray.origin, ray, a, t_max);
            };
            let origin = ray.moved_back(&[*x, *y, *z], setup.moment).origin;
            return sphere.intersect_from(origin, ray, a, t_max);
        }
        let MovingSetup { shear, moment, .. } = *setup;
        let velocity = self.motion.velocity_or_zero(id);
        match tagged.kind() {
            PrimitiveKind::Triangle => {
                let triangle = &self.triangles[i];
                let shear = || shear.moved_back(velocity, moment, self.magnitude);
                watertight::intersect_in(triangle, &shear(), ray.t_min, t_max, || {
                    let relative = ray.moved_back(velocity, moment);
                    precise::intersect(triangle, &relative, &shear(), t_max)
                })
            }
            PrimitiveKind::Polygon => {
                let relative = ray.moved_back(velocity, moment);
                let shear = shear.moved_back(velocity, moment, self.magnitude);
                self.polygons[i].intersect(&self.polygon_vertices, &relative, &shear, t_max)
            }
            PrimitiveKind::Sphere | PrimitiveKind::Cone => {
                self.cones[i].intersect(&ray.moved_back(velocity, moment), t_max)
            }
        }
    }

    pub(crate) fn motion(&self) -> &Motion<S> {
        &self.motion
    }

    /// From now on bounds hold the way within segment `k` of `n` equal ones of the exposure. They
    /// are padded as for all of it: tests round as if a primitive were where it is at time 0.
    pub(crate) fn narrow_to(&mut self, k: usize, n: usize) {
        let margin = S::EPSILON * self.magnitude * S::from_f64(PADDING_ULPS);
        self.motion.narrow_to(k, n, margin);
    }
}

/// Tests find primitives where they are at time 0; bounds hold their whole way.
impl<S: Scalar> Primitives<S> for MixedSet<S> {
    #[inline(always)]
    fn len(&self) -> usize {
        self.order.len()
    }

    fn bounds(&self, id: u32) -> Aabb<S> {
        let tagged = self.order[id as usize];
        let i = tagged.index();
        let still = match tagged.kind() {
            PrimitiveKind::Triangle => {
                Aabb::of_triangle(&self.triangles[i].map(Vec3::<S>::from_array))
            }
            PrimitiveKind::Polygon => self.polygons[i].bounds(),
            PrimitiveKind::Sphere => self.spheres[i].bounds(),
            PrimitiveKind::Cone => self.cones[i].bounds(),
        };
        self.motion.swept(id, still).expanded(self.motion.margin())
    }

    fn extent(&self, id: u32, direction: DVec3) -> (f64, f64) {
        let tagged = self.order[id as usize];
        let i = tagged.index();
        let still = match tagged.kind() {
            PrimitiveKind::Triangle => extent_of_points(&self.triangles[i], direction),
            PrimitiveKind::Polygon => self.polygons[i].extent(&self.polygon_vertices, direction),
            PrimitiveKind::Sphere => self.spheres[i].extent(direction),
            PrimitiveKind::Cone => self.cones[i].extent(direction),
        };
        let (low, high) = self.motion.swept_extent(id, still, direction);
        let margin = self.motion.margin().to_f64() * direction.abs().element_sum();
        (low - margin, high + margin)
    }

    fn farthest(&self, id: u32, from: DVec3) -> f64 {
        let tagged = self.order[id as usize];
        let i = tagged.index();
        let still = |from| match tagged.kind() {
            PrimitiveKind::Triangle => distance_to_points(&self.triangles[i], from),
            PrimitiveKind::Polygon => self.polygons[i].farthest(&self.polygon_vertices, from),
            PrimitiveKind::Sphere => self.spheres[i].farthest(from),
            PrimitiveKind::Cone => self.cones[i].farthest(from),
        };
        // the distance is convex along the way: one of its ends is farthest
        let farthest = match self.motion.displacements(id) {
            Some([first, last]) => still(from - first).max(still(from - last)),
            None => still(from),
        };
        farthest + self.motion.margin().to_f64()
    }

    fn hull(&self, id: u32, balls: &mut Vec<Ball>) {
        let first = balls.len();
        let tagged = self.order[id as usize];
        let i = tagged.index();
        match tagged.kind() {
            PrimitiveKind::Triangle => balls_around(&self.triangles[i], 0.0, balls),
            PrimitiveKind::Polygon => self.polygons[i].hull(&self.polygon_vertices, balls),
            PrimitiveKind::Sphere => self.spheres[i].hull(balls),
            PrimitiveKind::Cone => self.cones[i].hull(balls),
        }
        if let Some([from, to]) = self.motion.displacements(id) {
            for still in first..balls.len() {
                let ball = balls[still];
                balls[still].center = ball.center + from;
                balls.push(Ball { center: ball.center + to, ..ball });
            }
        }
        let margin = self.motion.margin().to_f64();
        balls[first..].iter_mut().for_each(|ball| ball.radius += margin);
    }

    fn corners(&self, id: u32) -> Option<[Vec3<S>; 3]> {
        if self.moves(id) { None } else { self.triangle(id) }
    }

    fn corners_in_block(&self, id: u32) -> Option<[Vec3<S>; 3]> {
        if self.has_motion() { self.triangle(id) } else { None }
    }

    fn move_as_one(&self, ids: &[u32]) -> bool {
        self.motion.is_one(ids)
    }

    fn moves(&self, id: u32) -> bool {
        self.motion.velocity(id).is_some()
    }

    fn kind(&self, id: u32) -> PrimitiveKind {
        self.order[id as usize].kind()
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
        size_of_val(self.order.as_slice())
            + size_of_val(self.triangles.as_slice())
            + size_of_val(self.polygons.as_slice())
            + size_of_val(self.polygon_vertices.as_slice())
            + size_of_val(self.spheres.as_slice())
            + size_of_val(self.cones.as_slice())
            + size_of_val(self.moving_spheres.as_slice())
            + self.transmissive.bytes()
            + self.motion.bytes()
            + self.instances.bytes()
    }
}

impl<S: Scalar> PrimSet<S> for MixedSet<S> {
    type RaySetup = Shear<S>;

    #[inline(always)]
    fn setup(&self, ray: &Ray<S>) -> Shear<S> {
        Shear::of(ray, self.magnitude)
    }

    #[inline(always)]
    fn intersect(&self, id: u32, ray: &Ray<S>, shear: &Shear<S>, t_max: S) -> Option<S> {
        self.tested::<Watertight, RearrangedSphere>(id, ray, shear, shear, t_max)
    }
}
