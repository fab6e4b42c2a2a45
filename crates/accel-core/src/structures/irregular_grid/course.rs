//! A ray's way over the lattice, from one grown box to the next.

use super::Point;
use super::subdivide::Cell;
use crate::ray::Ray;
use crate::scalar::{Scalar, Vector};

/// A ray in lattice cells; its parameter stays what it was.
#[derive(Debug, Clone, Copy)]
pub(super) struct Course<S> {
    origin: [S; 3],
    /// 0 on an axis whose component is too small to divide by.
    direction: [S; 3],
    inverse: [S; 3],
}

impl<S: Scalar> Course<S> {
    /// For a lattice that begins at `low` and has `a_length` cells a unit of length.
    #[inline(always)]
    pub(super) fn of(ray: &Ray<S>, low: crate::Vec3<S>, a_length: [S; 3]) -> Self {
        let (from, along) = ((ray.origin - low).to_array(), ray.direction.to_array());
        let mut this =
            Self { origin: [S::ZERO; 3], direction: [S::ZERO; 3], inverse: [S::ZERO; 3] };
        for k in 0..3 {
            this.origin[k] = from[k] * a_length[k];
            this.direction[k] = along[k] * a_length[k];
            this.inverse[k] = S::ONE / this.direction[k];
            if !this.inverse[k].is_finite() {
                this.direction[k] = S::ZERO;
            }
        }
        this
    }

    /// The lattice point at a parameter, within the lattice.
    #[inline(always)]
    pub(super) fn point(&self, t: S, resolution: [u32; 3]) -> Point {
        std::array::from_fn(|k| within(self.origin[k] + self.direction[k] * t, resolution[k]))
    }

    /// Where the ray leaves the box of a cell, and along which axis; axis 3 when nowhere.
    #[inline(always)]
    pub(super) fn exit(&self, cell: &Cell) -> (S, usize) {
        let (mut exit, mut axis) = (S::INFINITY, 3);
        for k in 0..3 {
            let forward = self.direction[k] > S::ZERO;
            let plane =
                if forward { i32::from(cell.last[k]) + 1 } else { i32::from(cell.first[k]) };
            let t = (S::from_i32(plane) - self.origin[k]) * self.inverse[k];
            if self.direction[k] != S::ZERO && t < exit {
                (exit, axis) = (t, k);
            }
        }
        (exit, axis)
    }

    /// Moves to the point beyond that exit; false when it lies outside of the lattice.
    #[inline(always)]
    pub(super) fn advance(
        &self,
        at: &mut Point,
        cell: &Cell,
        (exit, axis): (S, usize),
        resolution: [u32; 3],
    ) -> bool {
        for k in 0..3 {
            let there = within(self.origin[k] + self.direction[k] * exit, resolution[k]);
            // never back, whatever rounding says; the exit's axis goes on for certain
            at[k] = if self.direction[k] > S::ZERO {
                let beyond = if k == axis { u32::from(cell.last[k]) + 1 } else { at[k] };
                if k == axis { beyond } else { there.max(beyond) }
            } else if self.direction[k] < S::ZERO {
                let beyond =
                    if k == axis { u32::from(cell.first[k]).wrapping_sub(1) } else { at[k] };
                if k == axis { beyond } else { there.min(beyond) }
            } else {
                at[k]
            };
        }
        (0..3).all(|k| at[k] < resolution[k])
    }
}

/// The lattice cell at a coordinate, within the lattice.
#[inline(always)]
fn within<S: Scalar>(x: S, resolution: u32) -> u32 {
    // truncation is the floor of what is not negative, and negative becomes 0
    x.to_i32().clamp(0, resolution as i32 - 1) as u32
}
