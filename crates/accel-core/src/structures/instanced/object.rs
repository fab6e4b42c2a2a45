//! What the structures of both levels are built over: the primitives of one object, and the boxes of its copies.

use glam::DVec3;

use crate::geometry::aabb::Aabb;
use crate::geometry::ray::Ray;
use crate::geometry::scalar::{Scalar, Vector};
use crate::primitives::{Ball, PrimSet, PrimitiveKind};

/// Ids of primitives.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Members {
    /// From the first one on, of each copy.
    From(u32),
    /// Those that are in no copy of anything.
    List(Vec<u32>),
}

impl Members {
    /// The id in the set of a primitive of the object, for the copy whose first id is given.
    #[inline(always)]
    pub fn id(&self, first: u32, own: u32) -> u32 {
        match self {
            Self::From(_) => first + own,
            Self::List(ids) => ids[own as usize],
        }
    }

    /// The id of a primitive of the first copy.
    pub fn of_first(&self, own: u32) -> u32 {
        match self {
            Self::From(first) => first + own,
            Self::List(ids) => ids[own as usize],
        }
    }
}

/// The first copy of an object as a set of its own. Bounds are larger by a margin, so that they hold what any
/// other copy's primitives are when they are brought here, and what a ray's rounding adds.
pub(super) struct Part<'a, S: Scalar, P> {
    pub prims: &'a P,
    pub members: &'a Members,
    pub count: u32,
    pub margin: S,
    pub magnitude: S,
}

impl<S: Scalar, P: PrimSet<S>> PrimSet<S> for Part<'_, S, P> {
    type RaySetup = P::RaySetup;

    fn len(&self) -> usize {
        self.count as usize
    }

    fn bounds(&self, id: u32) -> Aabb<S> {
        self.prims.bounds(self.members.of_first(id)).expanded(self.margin)
    }

    fn extent(&self, id: u32, direction: DVec3) -> (f64, f64) {
        let (low, high) = self.prims.extent(self.members.of_first(id), direction);
        let more = self.margin.to_f64() * direction.abs().element_sum();
        (low - more, high + more)
    }

    fn farthest(&self, id: u32, from: DVec3) -> f64 {
        self.prims.farthest(self.members.of_first(id), from) + 2.0 * self.margin.to_f64()
    }

    fn hull(&self, id: u32, balls: &mut Vec<Ball>) {
        let before = balls.len();
        self.prims.hull(self.members.of_first(id), balls);
        for ball in &mut balls[before..] {
            ball.radius += 2.0 * self.margin.to_f64();
        }
    }

    fn kind(&self, id: u32) -> PrimitiveKind {
        self.prims.kind(self.members.of_first(id))
    }

    fn setup(&self, ray: &Ray<S>) -> Self::RaySetup {
        self.prims.setup(ray)
    }

    fn intersect(&self, id: u32, ray: &Ray<S>, setup: &Self::RaySetup, t_max: S) -> Option<S> {
        self.prims.intersect(self.members.of_first(id), ray, setup, t_max)
    }

    fn is_opaque(&self, id: u32) -> bool {
        self.prims.is_opaque(self.members.of_first(id))
    }

    fn magnitude(&self) -> S {
        self.magnitude
    }

    fn bytes(&self) -> usize {
        0
    }
}

/// The boxes of copies, as a set that structures divide and nobody tests.
pub(super) struct Boxes<'a, S: Scalar>(pub &'a [Aabb<S>]);

impl<S: Scalar> PrimSet<S> for Boxes<'_, S> {
    type RaySetup = ();

    fn len(&self) -> usize {
        self.0.len()
    }

    fn bounds(&self, id: u32) -> Aabb<S> {
        self.0[id as usize]
    }

    fn extent(&self, id: u32, direction: DVec3) -> (f64, f64) {
        let Aabb { min, max } = self.0[id as usize].in_double();
        let (a, b) = (min * direction, max * direction);
        (a.min(b).element_sum(), a.max(b).element_sum())
    }

    fn farthest(&self, id: u32, from: DVec3) -> f64 {
        let Aabb { min, max } = self.0[id as usize].in_double();
        (min - from).abs().max((max - from).abs()).length()
    }

    fn hull(&self, id: u32, balls: &mut Vec<Ball>) {
        let Aabb { min, max } = self.0[id as usize].in_double();
        let corner = |k: u32| {
            let pick = |axis: usize| if k >> axis & 1 == 0 { min[axis] } else { max[axis] };
            Ball { center: DVec3::new(pick(0), pick(1), pick(2)), radius: 0.0 }
        };
        balls.extend((0..8).map(corner));
    }

    fn kind(&self, _: u32) -> PrimitiveKind {
        PrimitiveKind::Polygon
    }

    fn setup(&self, _: &Ray<S>) {}

    fn intersect(&self, _: u32, _: &Ray<S>, (): &(), _: S) -> Option<S> {
        None
    }

    fn is_opaque(&self, _: u32) -> bool {
        true
    }

    fn magnitude(&self) -> S {
        self.0.iter().fold(S::ZERO, |m, b| m.greater(b.magnitude()))
    }

    fn bytes(&self) -> usize {
        size_of_val(self.0)
    }
}

/// The box of all primitives of a copy.
pub(super) fn bounds_of<S: Scalar, P: PrimSet<S>>(
    prims: &P,
    ids: impl Iterator<Item = u32>,
) -> Aabb<S> {
    ids.fold(Aabb::empty(), |all, id| all.union(prims.bounds(id)))
}

/// A point or direction in the other type.
pub(super) fn rounded<S: Scalar>(v: DVec3) -> crate::Vec3<S> {
    crate::Vec3::<S>::from_dvec3(v)
}
