//! The space in which the watertight test sees triangles: the ray runs along +z from the origin.
//!
//! Paper: S. Woop, C. Benthin, I. Wald, "Watertight Ray/Triangle Intersection", JCGT 2(1), 2013.

use crate::geometry::ray::Ray;
use crate::geometry::scalar::{Scalar, Vector};

/// The ray's shear to the axis it runs along most.
#[derive(Debug, Clone, Copy)]
pub struct Shear<S: Scalar> {
    /// Axes in the order x, y, z of the sheared space; a permutation of 0, 1, 2.
    pub(super) axes: [usize; 3],
    pub(super) origin: [S; 3],
    /// The first is NaN where a component is too small (see [`Scalar::LEAST_SLOPE`]): no triangle
    /// then passes for one that is hit, or missed, before `precise.rs` has judged it.
    pub(super) shear: [S; 3],
    /// Four times the scene's largest coordinate; see `precise.rs`.
    pub(super) fine: S,
    /// 13 epsilons of the largest depth of a corner: what bounds the rounding of a hit's; see
    /// `precise.rs`.
    pub(super) near: S,
}

/// The longest axis by `x > y`, `x > z`, `y > z`, the first of these the lowest bit; z in doubt.
const LONGEST: [usize; 8] = [2, 2, 2, 0, 1, 2, 1, 0];
/// The other two axes, so that a ray along it sees triangles wound as they are.
const OTHERS: [[[usize; 2]; 2]; 3] = [[[1, 2], [2, 1]], [[2, 0], [0, 2]], [[0, 1], [1, 0]]];

impl<S: Scalar> Shear<S> {
    /// The shear that maps `ray` to the +z axis through the origin, for corners of which no
    /// coordinate is larger than `magnitude`.
    #[inline(always)]
    pub fn of(ray: &Ray<S>, magnitude: S) -> Self {
        let this = Self::of_any(ray, magnitude);
        let [x, y, z] = this.shear;
        let is_small = |slope: S| slope.abs() < S::LEAST_SLOPE;
        // the scalar alone: a shear that is changed in memory is waited for
        let x = if is_small(x) || is_small(y) { this.refused_small(ray) } else { x };
        Self { shear: [x, y, z], ..this }
    }

    /// The first factor, or NaN where a component is too small, but not zero.
    #[cold]
    #[inline(never)]
    fn refused_small(self, ray: &Ray<S>) -> S {
        let d = ray.direction.to_array();
        let is_too_small =
            |i: usize| d[self.axes[i]] != S::ZERO && self.shear[i].abs() < S::LEAST_SLOPE;
        if is_too_small(0) || is_too_small(1) { S::from_f64(f64::NAN) } else { self.shear[0] }
    }

    /// Returns whether a component is too small.
    #[inline(always)]
    pub(crate) fn is_too_small(&self) -> bool {
        !self.shear[0].is_finite()
    }

    /// [`Shear::of`] without regard to the size of components.
    #[inline(always)]
    pub(crate) fn of_any(ray: &Ray<S>, magnitude: S) -> Self {
        let d = ray.direction.to_array();
        let o = ray.origin.to_array();
        let (ax, ay, az) = (d[0].abs(), d[1].abs(), d[2].abs());
        // by tables: which axis is the longest is as good as random, and a branch would guess
        let order = usize::from(ax > ay) | usize::from(ax > az) << 1 | usize::from(ay > az) << 2;
        let kz = LONGEST[order];
        let [kx, ky] = OTHERS[kz][usize::from(d[kz] < S::ZERO)];
        let axes = [kx, ky, kz];
        // SAFETY: the tables hold axes
        let (origin, [dx, dy, dz]) = unsafe { (along(&o, axes), along(&d, axes)) };
        let inv = S::ONE / dz;
        Self {
            axes,
            origin,
            shear: [dx * inv, dy * inv, inv],
            fine: fine(magnitude),
            near: near(magnitude, origin[2]),
        }
    }

    /// The shear of the same ray from an origin moved back along a way of this velocity, to the bit
    /// that of [`Shear::of`] with the same `magnitude`: all else depends on the direction alone.
    #[inline(always)]
    pub(crate) fn moved_back(&self, velocity: &[S; 3], time: S, magnitude: S) -> Self {
        // SAFETY: `axes` is only ever set by `of`
        let velocity = unsafe { along(velocity, self.axes) };
        let origin = std::array::from_fn(|k| self.origin[k] - velocity[k] * time);
        Self { origin, near: near(magnitude, origin[2]), ..*self }
    }

    /// Scale of the third coordinate of a sheared vertex.
    #[inline(always)]
    pub(crate) fn depth_scale(&self) -> S {
        self.shear[2]
    }

    /// A vertex in the sheared space; `z` is still to be scaled by the third shear factor.
    #[inline(always)]
    pub(crate) fn apply(&self, v: &[S; 3]) -> [S; 3] {
        // SAFETY: `axes` is only ever set by `of`, though other tests read it, to a permutation of
        // 0, 1, 2.
        let [x, y, z] = unsafe { along(v, self.axes) };
        let [x, y, z] = [x - self.origin[0], y - self.origin[1], z - self.origin[2]];
        [x - self.shear[0] * z, y - self.shear[1] * z, z]
    }
}

/// [`Shear::fine`] for corners of which no coordinate is larger than `magnitude`; see
/// `proofs/weights.gappa`.
#[inline(always)]
pub(super) fn fine<S: Scalar>(magnitude: S) -> S {
    S::from_i32(4) * magnitude
}

/// Twelve suffice: see `proofs/near.gappa`.
#[inline(always)]
pub(super) fn near_factor<S: Scalar>() -> S {
    S::from_i32(13) * S::EPSILON
}

/// [`Shear::near`] for a ray that begins at this depth.
#[inline(always)]
fn near<S: Scalar>(magnitude: S, depth: S) -> S {
    near_factor::<S>() * (magnitude + depth.abs())
}

/// Coordinates by axis, in that order.
///
/// # Safety
/// Axes are below 3.
#[inline(always)]
unsafe fn along<S: Scalar>(v: &[S; 3], [kx, ky, kz]: [usize; 3]) -> [S; 3] {
    debug_assert!(kx < 3 && ky < 3 && kz < 3);
    // SAFETY: the caller's
    unsafe { [*v.get_unchecked(kx), *v.get_unchecked(ky), *v.get_unchecked(kz)] }
}
