//! A ray's way over the lattice, from one grown box to the next, all axes in the lanes of a vector
//! and without branches: which face a ray leaves through is as good as random, and a processor that
//! guesses wrong loses more than a step.

use wide::{i32x4, i32x8, u8x16};

use crate::geometry::aabb::exit_factor;
use crate::geometry::lanes::{Eight, Four, Lanes};
use crate::geometry::ray::Ray;
use crate::geometry::scalar::{EightOf, FourOf, Scalar, Vector};
use crate::structures::irregular_grid::voxels::{Point, Voxel};

/// Position of a grid's lattice.
#[derive(Debug, Clone, Copy)]
pub(super) struct LatticeFrame<S: Scalar> {
    low: FourOf<S>,
    /// Lattice cells per unit of length.
    per_length: FourOf<S>,
    /// Lattice cells less one.
    last: Point,
    last_coordinate: FourOf<S>,
    size: FourOf<S>,
}

impl<S: Scalar> LatticeFrame<S> {
    pub(super) fn new(low: crate::Vec3<S>, per_length: [S; 3], resolution: [u32; 3]) -> Self {
        let [x, y, z] = resolution.map(|n| n as i32 - 1);
        let last = i32x4::new([x, y, z, 0]);
        Self {
            low: FourOf::<S>::of_axes(low.to_array()),
            per_length: FourOf::<S>::of_axes(per_length),
            last,
            last_coordinate: FourOf::<S>::from_i32(last),
            size: FourOf::<S>::from_i32(last + i32x4::splat(1)),
        }
    }

    /// The lattice cell at a coordinate, within the lattice.
    #[inline(always)]
    fn within(&self, x: FourOf<S>) -> Point {
        x.greater(FourOf::<S>::splat(S::ZERO)).lesser(self.last_coordinate).truncate()
    }

    /// On an axis: where the lattice begins, cells per unit of length, and cells.
    #[inline(always)]
    pub(super) fn along(&self, axis: usize) -> [S; 3] {
        [&self.low, &self.per_length, &self.size].map(|all| all.to_array()[axis])
    }

    /// The last lattice coordinate on an axis.
    #[inline(always)]
    pub(super) fn last_along(&self, axis: usize) -> i32x8 {
        i32x8::splat(self.last.to_array()[axis])
    }

    /// The lattice cells at coordinates on an axis, within the lattice.
    #[inline(always)]
    pub(super) fn within_along(&self, axis: usize, x: EightOf<S>) -> i32x8 {
        let splat = EightOf::<S>::splat;
        let last = self.last_coordinate.to_array()[axis];
        x.greater(splat(S::ZERO)).lesser(splat(last)).truncate()
    }

    /// True when the point is none of the lattice.
    #[inline(always)]
    fn is_left(&self, p: Point) -> bool {
        (p.simd_gt(self.last) | p).to_bitmask() & 7 != 0
    }
}

/// A ray in lattice cells; its parameter stays what it was.
#[derive(Debug, Clone, Copy)]
pub(super) struct LatticeRayState<S: Scalar> {
    origin: FourOf<S>,
    direction: FourOf<S>,
    inverse: FourOf<S>,
    /// Picks the far coordinates of a voxel's box.
    far: u8x16,
    /// 0 on an axis along which the ray goes up, -1 where it goes down.
    down: Point,
}

impl<S: Scalar> LatticeRayState<S> {
    /// The course of a ray and the lattice point where it enters, or starts; `None` when it passes
    /// by.
    #[inline(always)]
    pub(super) fn of(ray: &Ray<S>, place: &LatticeFrame<S>) -> Option<(Self, Point)> {
        let splat = FourOf::<S>::splat;
        let (zero, infinity) = (splat(S::ZERO), splat(S::INFINITY));
        let origin = (FourOf::<S>::of_axes(ray.origin.to_array()) - place.low) * place.per_length;
        let direction = FourOf::<S>::of_axes(ray.direction.to_array()) * place.per_length;
        let inverse = splat(S::ONE) / direction;
        // not where it is too small to divide by, nor in the fourth lane: there every plane is at
        // infinity, and no point moves
        let moves = (inverse * zero).at_most(zero);
        let (low, high) = ((zero - origin) * inverse, (place.size - origin) * inverse);
        let near = low.lesser(high).where_set(moves, zero - infinity);
        // later by two ulps (Ize 2013); that no hit is lost is due to the padding of the boxes that
        // the lattice spans
        let padding = splat(exit_factor());
        let far = (low.greater(high) * padding).where_set(moves, infinity);
        let [near, far] = [near.to_array(), far.to_array()];
        let start = near[0].greater(near[1]).greater(near[2]).greater(ray.t_min);
        let end = far[0].lesser(far[1]).lesser(far[2]).lesser(ray.t_max);
        let is_inside = zero.at_most(origin) & origin.at_most(place.size) | moves;
        if start > end || is_inside.to_bitmask() != 15 {
            return None;
        }
        let down = moves & !zero.at_most(direction);
        let direction = direction.where_set(moves, zero);
        let at = place.within(origin + direction * splat(start));
        let this = Self {
            origin: origin.where_set(moves, splat(-S::ONE)),
            direction,
            inverse: inverse.where_set(moves, infinity),
            far: Voxel::far_coordinates(down),
            down,
        };
        Some((this, at))
    }

    /// Goes on to the point where the ray leaves a voxel's box. False when that lies outside of the
    /// lattice or beyond `t_max`; the point has no meaning then. Without branches.
    #[inline(always)]
    pub(super) fn leave(
        &self,
        at: &mut Point,
        voxel: &Voxel,
        t_max: S,
        place: &LatticeFrame<S>,
    ) -> bool {
        let planes = voxel.pick(self.far);
        let exits = (FourOf::<S>::from_i32(planes) - self.origin) * self.inverse;
        let [x, y, z, _] = exits.to_array();
        let exit = x.lesser(y).lesser(z);
        let t = FourOf::<S>::splat(exit);
        let there = place.within(self.origin + self.direction * t);
        // never back, whatever rounding says: all ones turn the order round
        let onward = (there ^ self.down).max(*at ^ self.down) ^ self.down;
        let beyond = planes + self.down;
        *at = exits.at_most(t).select(beyond, onward);
        // not finite: it leaves through no face, or the planes' parameters overflow
        (exit <= t_max) & exit.is_finite() & !place.is_left(*at)
    }
}
