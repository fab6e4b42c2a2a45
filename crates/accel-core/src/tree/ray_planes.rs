//! Parameters at which a ray meets axis-parallel planes, and the cell it is in.
//!
//! A plane always gets the same parameter, so comparisons between parameters never contradict
//! each other: a traversal that enters the next cell at the exit of the last one always moves on.

use crate::geometry::aabb::Aabb;
use crate::geometry::ray::Ray;
use crate::geometry::scalar::{Scalar, Vector};

/// A ray prepared for planes.
pub(crate) struct RayPlanes<S> {
    origin: [S; 3],
    /// Reciprocal of the direction; +infinity where that is zero.
    inverse: [S; 3],
    /// Bit k is set when the ray runs downwards on axis k.
    downwards: u32,
}

impl<S: Scalar> RayPlanes<S> {
    #[inline(always)]
    pub(crate) fn new(ray: &Ray<S>) -> Self {
        let d = ray.direction.to_array();
        let mut inverse = [S::INFINITY; 3];
        let mut downwards = 0;
        for k in 0..3 {
            if d[k] != S::ZERO {
                inverse[k] = S::ONE / d[k];
            }
            downwards |= u32::from(d[k] < S::ZERO) << k;
        }
        Self { origin: ray.origin.to_array(), inverse, downwards }
    }

    /// Parameter at which the plane is crossed. For a ray parallel to it: infinity when the ray
    /// stays below, minus infinity above, NaN within.
    #[inline(always)]
    pub(crate) fn crossing(&self, axis: usize, plane: S) -> S {
        (plane - self.origin[axis]) * self.inverse[axis]
    }

    /// [`RayPlanes::crossing`], rounded down and up by more than its error
    /// (`proofs/tree_planes.gappa`).
    #[inline(always)]
    pub(crate) fn crossing_interval(&self, axis: usize, plane: S) -> (S, S) {
        let t = self.crossing(axis, plane);
        let four = S::from_i32(4) * S::EPSILON;
        let (a, b) = (t * (S::ONE - four), t * (S::ONE + four));
        if t < S::ZERO { (b, a) } else { (a, b) }
    }

    /// Bit k is set when the ray runs downwards on axis k: what is near on that axis is above.
    #[inline(always)]
    pub(crate) fn downwards(&self) -> u32 {
        self.downwards
    }

    /// The whole box as the cell the ray is in.
    #[inline(always)]
    pub(crate) fn root(&self, bounds: &Aabb<S>) -> RayCell<S> {
        let (lo, hi) = (bounds.min.to_array(), bounds.max.to_array());
        let mut exit = [S::INFINITY; 3];
        for k in 0..3 {
            let far = if self.downwards >> k & 1 == 1 { lo[k] } else { hi[k] };
            exit[k] = self.crossing(k, far).lesser(S::INFINITY);
        }
        RayCell { cell: 0, exit }
    }

    /// The child of an inner cell in which the ray is at parameter `t`; on a plane, the child
    /// behind it.
    #[inline(always)]
    pub(crate) fn child(
        &self,
        parent: &RayCell<S>,
        planes: &[S; 3],
        first_child: u32,
        t: S,
    ) -> RayCell<S> {
        // without a loop, which the compiler takes apart too late to keep its arrays in registers
        let side = |k: usize| {
            let crossing = self.crossing(k, planes[k]);
            let is_behind = crossing <= t;
            let exit = parent.exit[k];
            (u32::from(is_behind) << k, if is_behind { exit } else { crossing.lesser(exit) })
        };
        let ((x, exit_x), (y, exit_y), (z, exit_z)) = (side(0), side(1), side(2));
        RayCell {
            cell: first_child + ((x | y | z) ^ self.downwards),
            exit: [exit_x, exit_y, exit_z],
        }
    }
}

/// A cell on a ray's way.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RayCell<S> {
    /// Number of the cell.
    pub(crate) cell: u32,
    /// Parameters of the far planes of its box.
    exit: [S; 3],
}

impl<S: Scalar> RayCell<S> {
    /// Parameter at which the ray leaves the cell.
    #[inline(always)]
    pub(crate) fn exit(&self) -> S {
        self.exit[0].lesser(self.exit[1]).lesser(self.exit[2])
    }

    /// A place for an array that is yet to be filled.
    pub(crate) fn unset() -> Self {
        Self { cell: 0, exit: [S::INFINITY; 3] }
    }
}
