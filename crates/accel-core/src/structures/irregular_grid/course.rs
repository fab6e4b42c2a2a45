//! A ray's way over the lattice, from one grown box to the next, without branches: which face a ray
//! leaves through is as good as random, and a processor that guesses wrong loses more than a step.

use super::Point;
use super::subdivide::Cell;
use crate::ray::Ray;
use crate::scalar::{Scalar, Vector};

/// A ray in lattice cells; its parameter stays what it was.
#[derive(Debug, Clone, Copy)]
pub(super) struct Course<S> {
    origin: [S; 3],
    direction: [S; 3],
    inverse: [S; 3],
    /// 0 on an axis along which the ray goes up, -1 where it goes down.
    down: [i32; 3],
}

impl<S: Scalar> Course<S> {
    /// The course of a ray and its lattice point at parameter `start`, for a lattice of that
    /// resolution that begins at `low` and has `a_length` cells a unit of length.
    #[inline(always)]
    pub(super) fn of(
        ray: &Ray<S>,
        start: S,
        low: crate::Vec3<S>,
        a_length: [S; 3],
        resolution: [u32; 3],
    ) -> (Self, Point) {
        let (from, along) = ((ray.origin - low).to_array(), ray.direction.to_array());
        let (zero, one) = (S::ZERO, S::ONE);
        let mut this =
            Self { origin: [zero; 3], direction: [zero; 3], inverse: [zero; 3], down: [0; 3] };
        let mut at = [0; 3];
        for k in 0..3 {
            let origin = from[k] * a_length[k];
            let direction = along[k] * a_length[k];
            let inverse = one / direction;
            if inverse.is_finite() {
                this.origin[k] = origin;
                this.direction[k] = direction;
                this.inverse[k] = inverse;
                this.down[k] = if direction < zero { -1 } else { 0 };
            } else {
                // too small to divide by: every plane is at infinity, and no point moves
                this.origin[k] = -one;
                this.inverse[k] = S::INFINITY;
            }
            at[k] = within(origin + this.direction[k] * start, resolution[k]);
        }
        (this, at)
    }

    /// Where the ray passes the far planes of a cell's box.
    #[inline(always)]
    pub(super) fn exits(&self, cell: &Cell) -> [S; 3] {
        std::array::from_fn(|k| {
            let (first, last) = (i32::from(cell.first[k]), i32::from(cell.last[k]) + 1);
            let plane = last + (self.down[k] & (first - last));
            (S::from_i32(plane) - self.origin[k]) * self.inverse[k]
        })
    }

    /// Moves to the point beyond the nearest of these exits, `exit`; false when it lies outside of
    /// the lattice.
    #[inline(always)]
    pub(super) fn advance(
        &self,
        at: &mut Point,
        cell: &Cell,
        exits: [S; 3],
        exit: S,
        resolution: [u32; 3],
    ) -> bool {
        let mut inside = true;
        for k in 0..3 {
            let there = within(self.origin[k] + self.direction[k] * exit, resolution[k]) as i32;
            // never back, whatever rounding says: all ones turn the order round
            let down = self.down[k];
            let onward = (there ^ down).max(at[k] as i32 ^ down) ^ down;
            let (first, last) = (i32::from(cell.first[k]), i32::from(cell.last[k]));
            let beyond = last + 1 + (down & (first - last - 2));
            at[k] = if exits[k] <= exit { beyond } else { onward } as u32;
            inside &= at[k] < resolution[k];
        }
        inside
    }
}

/// The nearest exit.
#[inline(always)]
pub(super) fn nearest<S: Scalar>(exits: [S; 3]) -> S {
    exits[0].lesser(exits[1]).lesser(exits[2])
}

/// The lattice cell at a coordinate, within the lattice.
#[inline(always)]
fn within<S: Scalar>(x: S, resolution: u32) -> u32 {
    // truncation is the floor of what is not negative, and negative becomes 0
    x.to_i32().clamp(0, resolution as i32 - 1) as u32
}
