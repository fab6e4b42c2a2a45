//! Axis-aligned bounding boxes.

#![warn(missing_docs)]

use crate::geometry::scalar::{Scalar, Vec3, Vector};

/// An axis-aligned box; empty when `min > max` on any axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Aabb<S: Scalar> {
    /// Lower corner.
    pub min: Vec3<S>,
    /// Upper corner.
    pub max: Vec3<S>,
}

impl<S: Scalar> Aabb<S> {
    /// The box that holds nothing.
    #[inline(always)]
    pub fn empty() -> Self {
        Self { min: Vec3::<S>::splat(S::INFINITY), max: Vec3::<S>::splat(-S::INFINITY) }
    }

    /// The box that holds everything.
    pub fn everything() -> Self {
        Self { min: Vec3::<S>::splat(-S::INFINITY), max: Vec3::<S>::splat(S::INFINITY) }
    }

    /// The smallest box around three points.
    #[inline(always)]
    pub fn of_triangle(v: &[Vec3<S>; 3]) -> Self {
        Self { min: v[0].min(v[1]).min(v[2]), max: v[0].max(v[1]).max(v[2]) }
    }

    /// The smallest box around both.
    #[inline(always)]
    pub fn union(self, other: Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// Grown by `margin` on every side.
    #[inline(always)]
    pub fn expanded(self, margin: S) -> Self {
        let m = Vec3::<S>::splat(margin);
        Self { min: self.min - m, max: self.max + m }
    }

    /// Edge lengths.
    pub fn size(&self) -> Vec3<S> {
        self.max - self.min
    }

    /// The axis along which it is longest; of equal ones the lowest.
    pub(crate) fn longest_axis(&self) -> usize {
        let size = self.size().to_array();
        (1..3).fold(0, |longest, k| if size[k] > size[longest] { k } else { longest })
    }

    /// Both sides of a plane across an axis, the lower one first.
    #[inline(always)]
    pub(crate) fn cut(self, axis: usize, plane: S) -> [Self; 2] {
        let (mut lo, mut hi) = (self.min.to_array(), self.max.to_array());
        (lo[axis], hi[axis]) = (plane, plane);
        [
            Self { max: Vec3::<S>::from_array(hi), ..self },
            Self { min: Vec3::<S>::from_array(lo), ..self },
        ]
    }

    /// Half the surface, in f64.
    pub fn half_area(&self) -> f64 {
        let s = self.size().to_dvec3();
        s.x * s.y + s.y * s.z + s.z * s.x
    }

    /// All six numbers are finite and no axis is inverted.
    #[inline(always)]
    pub fn is_finite(&self) -> bool {
        self.min.is_finite() && self.max.is_finite()
    }

    /// The same box in f64.
    pub fn in_double(&self) -> Aabb<f64> {
        Aabb { min: self.min.to_dvec3(), max: self.max.to_dvec3() }
    }

    /// The largest absolute coordinate.
    pub fn magnitude(&self) -> S {
        let (lo, hi) = (self.min.to_array(), self.max.to_array());
        let mut m = S::ZERO;
        for k in 0..3 {
            m = m.greater(lo[k].abs()).greater(hi[k].abs());
        }
        m
    }

    /// The parameters at which the ray enters and leaves the box, within `[t_min, t_max]`;
    /// `None` when it misses. Rays inside a face's plane count as inside, and the exit is
    /// multiplied by [`exit_factor`]. What lies within a box padded as boxes are is never lost.
    #[inline(always)]
    pub fn clip(&self, origin: Vec3<S>, direction: Vec3<S>, t_min: S, t_max: S) -> Option<(S, S)> {
        self.clip_by(exit_factor(), origin, direction, t_min, t_max)
    }

    /// The same with exits that are `pad` times as far.
    #[inline(always)]
    pub(crate) fn clip_by(
        &self,
        pad: S,
        origin: Vec3<S>,
        direction: Vec3<S>,
        mut t_min: S,
        mut t_max: S,
    ) -> Option<(S, S)> {
        let (lo, hi) = (self.min.to_array(), self.max.to_array());
        let (o, d) = (origin.to_array(), direction.to_array());
        for k in 0..3 {
            if d[k] == S::ZERO {
                if o[k] < lo[k] || o[k] > hi[k] {
                    return None;
                }
                continue;
            }
            let inv = S::ONE / d[k];
            let a = (lo[k] - o[k]) * inv;
            let b = (hi[k] - o[k]) * inv;
            let (near, far) = if inv < S::ZERO { (b, a) } else { (a, b) };
            // lesser/greater keep the old bound when the new one is NaN (0 * infinity)
            t_min = near.greater(t_min);
            t_max = (far * pad).lesser(t_max);
        }
        (t_min <= t_max).then_some((t_min, t_max))
    }
}

/// Factor of the parameter at which a ray leaves a box (T. Ize, "Robust BVH Ray Traversal", JCGT
/// 2(2), 2013), for tight boxes: padded ones need none (`proofs/box_clip.gappa`).
#[inline(always)]
pub(crate) fn exit_factor<S: Scalar>() -> S {
    S::ONE + S::from_i32(2) * S::EPSILON
}
