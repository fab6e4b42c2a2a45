//! Rays and hits.

#![warn(missing_docs)]

use glam::DVec3;

use crate::geometry::scalar::{Scalar, Vec3, Vector};

/// The id of "no primitive".
pub const MISS: u32 = u32::MAX;

/// A ray with a closed parameter interval: a hit counts when `t_min <= t <= t_max`.
///
/// `direction` need not be of unit length; `t` is measured in multiples of it.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C)]
pub struct Ray<S: Scalar> {
    /// Start, world units.
    pub origin: Vec3<S>,
    /// Direction.
    pub direction: Vec3<S>,
    /// Smallest accepted parameter.
    pub t_min: S,
    /// Largest accepted parameter; may be infinite.
    pub t_max: S,
    /// The moment at which it sees moving primitives, from 0 (the shutter opens) to their
    /// exposure. Nothing else reads it.
    pub time: S,
}

impl<S: Scalar> Ray<S> {
    /// A ray from `origin` with the interval [0, infinity], at time 0.
    pub fn new(origin: Vec3<S>, direction: Vec3<S>) -> Self {
        Self { origin, direction, t_min: S::ZERO, t_max: S::INFINITY, time: S::ZERO }
    }

    /// [`Ray::new`] of coordinates in f64, rounded.
    pub fn from_dvec3(origin: DVec3, direction: DVec3) -> Self {
        Self::new(Vec3::<S>::from_dvec3(origin), Vec3::<S>::from_dvec3(direction))
    }

    /// The point at parameter `t`.
    #[inline(always)]
    pub fn at(&self, t: S) -> Vec3<S> {
        self.origin + self.direction * t
    }

    /// The same ray as what moves with this velocity sees it after `time`.
    #[inline(always)]
    pub(crate) fn moved_back(&self, velocity: &[S; 3], time: S) -> Self {
        Self { origin: self.origin - Vec3::<S>::from_array(*velocity) * time, ..*self }
    }

    /// The power of two that brings the largest component of the direction into [1, 2).
    #[inline(always)]
    pub(crate) fn unit_factor(&self) -> S {
        unit_factor(self.direction.to_array())
    }

    /// The same ray in f64.
    #[inline(always)]
    pub fn widened(&self) -> Ray<f64> {
        Ray {
            origin: self.origin.to_dvec3(),
            direction: self.direction.to_dvec3(),
            t_min: self.t_min.to_f64(),
            t_max: self.t_max.to_f64(),
            time: self.time.to_f64(),
        }
    }

    /// True when a structure may traverse it: finite origin and direction, a direction that is not
    /// zero, and an interval that is not empty (or NaN). Anything else is a miss by definition.
    #[inline(always)]
    pub fn is_traceable(&self) -> bool {
        self.origin.is_finite()
            && self.direction.is_finite()
            && self.direction != Vec3::<S>::splat(S::ZERO)
            && self.t_min <= self.t_max
    }
}

/// [`Ray::unit_factor`] of a ray in this direction.
#[inline(always)]
pub(crate) fn unit_factor<S: Scalar>([x, y, z]: [S; 3]) -> S {
    x.abs().greater(y.abs()).greater(z.abs()).to_unit_size()
}

/// The answer to a closest-hit query.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hit<S: Scalar> {
    /// Ray parameter of the hit; the ray's `t_max` for a miss.
    pub t: S,
    /// Primitive id, or [`MISS`].
    pub id: u32,
}

impl<S: Scalar> Hit<S> {
    /// Result for a ray without a hit.
    pub const NONE: Self = Self { t: S::INFINITY, id: MISS };

    /// True when something was hit.
    #[inline(always)]
    pub fn is_hit(&self) -> bool {
        self.id != MISS
    }
}
