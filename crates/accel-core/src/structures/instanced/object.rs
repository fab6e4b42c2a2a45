//! Objects and where they stand, and what the structures of both levels are built over: boxes.

use glam::{DAffine3, DVec3};

use crate::geometry::aabb::Aabb;
use crate::geometry::ray::Ray;
use crate::geometry::scalar::{Scalar, Vec3, Vector};
use crate::historical::bounds_rule::PADDING_ULPS;
use crate::primitives::instances::stretch;
use crate::primitives::{Ball, PrimitiveKind, Primitives};

/// Ids of the primitives of an object.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Members {
    /// Consecutive ones, of each copy.
    Consecutive,
    /// Those that are in no copy of anything.
    List(Vec<u32>),
}

impl Members {
    /// The id in the set of a primitive of the object, for the copy whose first id is given.
    #[inline(always)]
    pub fn id(&self, first: u32, own: u32) -> u32 {
        match self {
            Self::Consecutive => first + own,
            Self::List(ids) => ids[own as usize],
        }
    }

    pub fn bytes(&self) -> usize {
        match self {
            Self::Consecutive => 0,
            Self::List(ids) => size_of_val(ids.as_slice()),
        }
    }
}

/// An object with its structure.
pub(super) struct Object<T> {
    pub structure: T,
    pub members: Members,
    pub count: u32,
}

/// An object at a place.
pub(super) struct Copy<S: Scalar> {
    /// The box of its primitives, padded.
    pub bounds: Aabb<S>,
    pub object: u32,
    /// The id of its first primitive.
    pub first: u32,
    /// To the first copy; none for that itself.
    pub to_first: Option<DAffine3>,
}

impl<S: Scalar> Copy<S> {
    /// The ray in the space of the first copy, with the same parameters; `None` if its direction is
    /// no common one there.
    #[inline(always)]
    pub fn carried(&self, ray: &Ray<S>) -> Option<Ray<S>> {
        let Some(to_first) = &self.to_first else { return Some(*ray) };
        let direction = to_first.transform_vector3(ray.direction.to_dvec3());
        let length = direction.abs().element_sum();
        let [least, most] = S::DIRECTION_LENGTHS.map(S::to_f64);
        if !(length >= least && length <= most) {
            return None;
        }
        let origin = to_first.transform_point3(ray.origin.to_dvec3());
        let [origin, direction] = [origin, direction].map(Vec3::<S>::from_dvec3);
        Some(Ray { origin, direction, ..*ray })
    }
}

/// By how many epsilons the boxes of an object's primitives are larger than those of its first
/// copy: twice what padded boxes are, for the coordinates of the world where copies are rounded,
/// brought here, and for those of the ray here.
pub(super) fn margin(to_first: impl Iterator<Item = Option<DAffine3>>, magnitude: f64) -> f64 {
    let carried = |to_first: DAffine3| {
        stretch(&to_first.matrix3) * magnitude + to_first.translation.abs().max_element()
    };
    2.0 * PADDING_ULPS * (magnitude + to_first.flatten().map(carried).fold(magnitude, f64::max))
}

/// By how much the boxes of copies are larger, for the scene's largest coordinate.
pub(super) fn padding_of<S: Scalar>(magnitude: S) -> S {
    (S::EPSILON * magnitude * S::from_f64(2.0 * PADDING_ULPS)).greater(S::from_f64(2e-30))
}

/// The boxes of copies or of an object's primitives, as a set that structures divide and nobody
/// tests.
pub(super) struct Boxes<'a, S: Scalar>(pub &'a [Aabb<S>]);

impl<S: Scalar> Primitives<S> for Boxes<'_, S> {
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
