//! Sets of primitives: what structures are built over, and what rays are tested against.

#![warn(missing_docs)]

use std::ops::Range;

use glam::DVec3;

use crate::geometry::aabb::Aabb;
use crate::geometry::ray::{Hit, Ray};
use crate::geometry::ray_lanes::{LANES, RayLanes};
use crate::geometry::scalar::{Scalar, Vec3};
use crate::parallel::map_parts;
use crate::primitives::instances::Instances;
use crate::primitives::support::Ball;
use crate::primitives::triangle_block::TriangleBlock;

/// Kind of a primitive.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PrimitiveKind {
    /// A triangle or a patch.
    Triangle,
    /// A polygon.
    Polygon,
    /// A sphere.
    Sphere,
    /// A cone or cylinder.
    Cone,
}

/// Kind of a primitive in the upper two bits, index within the kind below.
#[derive(Debug, Clone, Copy)]
pub(super) struct TaggedIndex(u32);

impl TaggedIndex {
    /// Bits of an index.
    pub(super) const BITS: u32 = 30;

    pub(super) fn new(kind: PrimitiveKind, index: usize) -> Self {
        Self((kind as u32) << Self::BITS | index as u32)
    }

    #[inline(always)]
    pub(super) fn kind(self) -> PrimitiveKind {
        match self.0 >> Self::BITS {
            0 => PrimitiveKind::Triangle,
            1 => PrimitiveKind::Polygon,
            2 => PrimitiveKind::Sphere,
            _ => PrimitiveKind::Cone,
        }
    }

    #[inline(always)]
    pub(super) fn index(self) -> usize {
        (self.0 & ((1 << Self::BITS) - 1)) as usize
    }
}

/// Why a primitive cannot be part of a set.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[allow(missing_docs, reason = "the message of a variant says what its fields are")]
pub enum PrimitiveError {
    /// A NaN or infinite coordinate, or one too large for the scalar of the set.
    #[error("primitive {id} has a coordinate that is not finite (or too large for this precision)")]
    NotFinite { id: u32 },
    /// A sphere of a negative radius.
    #[error("sphere {id} has a negative radius")]
    NegativeRadius { id: u32 },
    /// A motion over a time that is negative or not finite.
    #[error("primitive {id}: its motion ends at a time that is negative or not finite")]
    Exposure { id: u32 },
    /// A polygon with fewer than three vertices.
    #[error("polygon {id} has {vertices} vertices; at least 3 are needed")]
    TooFewVertices {
        id: u32,
        /// Number of vertices it has.
        vertices: usize,
    },
    /// More primitives than ids.
    #[error("more than {limit} primitives of a kind")]
    TooMany { limit: u32 },
}

/// Primitives with ids `0..len()`, as what is built over them sees them: where they are, and not how
/// rays meet them.
pub trait Primitives<S: Scalar>: Send + Sync {
    /// Number of primitives.
    fn len(&self) -> usize;
    /// True when there are none.
    fn is_empty(&self) -> bool {
        self.len() == 0
    }
    /// Bounds that hold every point at which the primitive can be hit, up to the rounding of the
    /// hit itself.
    fn bounds(&self, id: u32) -> Aabb<S>;
    /// Smallest and largest dot product of `direction` (of any length) with a point at which the
    /// primitive can be hit, up to the rounding of the hit itself: its support, which bounding
    /// planes at a slant need. No looser than that of its vertices or discs.
    fn extent(&self, id: u32, direction: DVec3) -> (f64, f64);
    /// The largest distance from `from` to such a point, world units.
    fn farthest(&self, id: u32, from: DVec3) -> f64;
    /// Appends balls whose convex hull holds every such point: the vertices of a triangle or a
    /// polygon in the order of its outline, the sphere itself, the two ends of a cone; and, for
    /// one that moves, the same where it ends.
    fn hull(&self, id: u32, balls: &mut Vec<Ball>);
    /// The corners of all primitives, by id, where they are triangles at rest: what is asked of each
    /// primitive many times is found there without a call.
    fn triangles(&self) -> Option<&[[[S; 3]; 3]]> {
        None
    }
    /// The corners of a primitive that is a triangle at rest, for structures that cut it up.
    fn corners(&self, _id: u32) -> Option<[Vec3<S>; 3]> {
        None
    }
    /// The corners of a primitive that may be in a block of triangles, of one that moves where it
    /// is at time 0.
    fn corners_in_block(&self, id: u32) -> Option<[Vec3<S>; 3]> {
        if self.is_watertight() { self.corners(id) } else { None }
    }
    /// Returns whether all are triangles that [`Watertight`](super::Watertight) tests: another way
    /// to compute that test gives the set's own answers.
    fn is_watertight(&self) -> bool {
        false
    }
    /// Returns whether rays of different times meet it in different places.
    fn moves(&self, _id: u32) -> bool {
        false
    }
    /// Returns whether these, of one block, all move alike.
    fn move_as_one(&self, _ids: &[u32]) -> bool {
        true
    }
    /// Kind of the primitive.
    fn kind(&self, id: u32) -> PrimitiveKind;
    /// Primitives known to be copies of others.
    fn instances(&self) -> Option<&Instances> {
        None
    }
    /// False for primitives that let shadow rays pass.
    fn is_opaque(&self, id: u32) -> bool;
    /// The largest absolute coordinate of any bounds; known without a pass over the set.
    fn magnitude(&self) -> S;
    /// Bytes the set occupies.
    fn bytes(&self) -> usize;

    /// Bounds of all primitives; found in the current rayon pool, the same for any number of
    /// threads.
    fn scene_bounds(&self) -> Aabb<S> {
        let of_part =
            |ids: Range<u32>| ids.fold(Aabb::empty(), |all, id| all.union(self.bounds(id)));
        map_parts(self.len(), of_part).into_iter().fold(Aabb::empty(), Aabb::union)
    }
}

/// A set of primitives that rays are tested against.
pub trait PrimSet<S: Scalar>: Primitives<S> {
    /// Data that tests derive from a ray, computed once per ray.
    type RaySetup: Copy;

    /// True if lists of its primitives may be kept as blocks of triangles; false where no test is
    /// compiled for them.
    const HAS_BLOCKS: bool = false;
    /// True if it has tests that are compared with the default ones, for which neither mailboxes
    /// nor batches are compiled.
    const HAS_OTHER_TESTS: bool = false;
    /// Prepares a ray.
    fn setup(&self, ray: &Ray<S>) -> Self::RaySetup;
    /// Prepares eight rays, which `lanes` holds too: what [`PrimSet::setup`] says of each, by lane.
    #[inline(always)]
    fn setups(
        &self,
        rays: &[Ray<S>; LANES],
        _lanes: &RayLanes<S>,
    ) -> impl Fn(usize) -> Self::RaySetup {
        |lane| self.setup(&rays[lane])
    }
    /// Asks for the memory of a primitive that is looked at soon.
    #[inline(always)]
    fn prefetch(&self, _id: u32) {}
    /// The smallest `t` in `[ray.t_min, t_max]` at which the ray hits primitive `id`.
    fn intersect(&self, id: u32, ray: &Ray<S>, setup: &Self::RaySetup, t_max: S) -> Option<S>;
    /// Replaces `best` by a closer hit of a primitive of the block within the ray's interval, or by
    /// an equal one of a lower id. The block is made of triangles of this set
    /// ([`Primitives::corners_in_block`]).
    #[inline(always)]
    fn closest_in_block(
        &self,
        block: &TriangleBlock<S>,
        ray: &Ray<S>,
        setup: &Self::RaySetup,
        best: &mut Hit<S>,
    ) {
        let (ids, n) = block.ids();
        for &id in &ids[..n] {
            if let Some(t) = self.intersect(id, ray, setup, best.t)
                && (t < best.t || id < best.id)
            {
                *best = Hit { t, id };
            }
        }
    }
    /// Returns whether an opaque primitive of the block blocks the ray.
    #[inline(always)]
    fn is_blocked_in(
        &self,
        block: &TriangleBlock<S>,
        ray: &Ray<S>,
        setup: &Self::RaySetup,
    ) -> bool {
        let (ids, n) = block.ids();
        let blocks =
            |&id: &u32| self.intersect(id, ray, setup, ray.t_max).is_some() && self.is_opaque(id);
        ids[..n].iter().any(blocks)
    }
}

/// Methods that a view forwards to its field `set`.
macro_rules! as_its_set {
    ($scalar:ty) => {
        #[inline(always)]
        fn len(&self) -> usize {
            self.set.len()
        }

        fn bounds(&self, id: u32) -> Aabb<$scalar> {
            self.set.bounds(id)
        }

        fn extent(&self, id: u32, direction: DVec3) -> (f64, f64) {
            self.set.extent(id, direction)
        }

        fn farthest(&self, id: u32, from: DVec3) -> f64 {
            self.set.farthest(id, from)
        }

        fn hull(&self, id: u32, balls: &mut Vec<Ball>) {
            self.set.hull(id, balls);
        }

        fn moves(&self, id: u32) -> bool {
            Primitives::moves(&self.set, id)
        }

        fn kind(&self, id: u32) -> PrimitiveKind {
            self.set.kind(id)
        }

        #[inline(always)]
        fn is_opaque(&self, id: u32) -> bool {
            self.set.is_opaque(id)
        }

        fn magnitude(&self) -> $scalar {
            self.set.magnitude()
        }

        fn bytes(&self) -> usize {
            self.set.bytes()
        }
    };
}
pub(crate) use as_its_set;

/// A set of ids, a bit each up to the largest.
#[derive(Debug, Clone, Default)]
pub(crate) struct IdSet {
    words: Vec<u64>,
}

impl IdSet {
    pub(crate) fn of(ids: &[u32]) -> Self {
        let mut this = Self::default();
        ids.iter().for_each(|&id| this.insert(id));
        this
    }

    pub(crate) fn insert(&mut self, id: u32) {
        let word = id as usize / 64;
        if self.words.len() <= word {
            self.words.resize(word + 1, 0);
        }
        self.words[word] |= 1 << (id % 64);
    }

    #[inline(always)]
    pub(crate) fn contains(&self, id: u32) -> bool {
        self.words.get(id as usize / 64).is_some_and(|w| w >> (id % 64) & 1 == 1)
    }

    pub(crate) fn bytes(&self) -> usize {
        self.words.len() * 8
    }
}
