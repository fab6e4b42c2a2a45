//! The lattice that all cells of an irregular grid lie on: the top grid, halved so and so often.

use crate::geometry::aabb::Aabb;
use crate::geometry::scalar::{Scalar, Vector};

/// Coordinates after the last lattice cell fit into 16 bits.
const MOST_CELLS: u32 = (1 << 16) - 1;
/// Most halvings of a cell of the top grid.
const MOST_LEVELS: u32 = 15;

/// Position of the lattice; in f64 for the build.
#[derive(Debug, Clone, Copy)]
pub(super) struct Lattice {
    /// Lower corner, world units.
    pub(super) low: [f64; 3],
    /// Sides of a lattice cell, world units.
    pub(super) side: [f64; 3],
    /// Cells of the top grid on each axis.
    pub(super) top: [u32; 3],
    /// How often a cell of the top grid is halved along each axis down to a lattice cell.
    pub(super) levels: [u32; 3],
}

impl Lattice {
    /// Over `bounds`, with cells no smaller than `smallest` but for axes that the top grid does
    /// not divide.
    pub(super) fn new<S: Scalar>(bounds: &Aabb<S>, top: [u32; 3], smallest: f64) -> Self {
        let size = bounds.size().to_array().map(S::to_f64);
        let top = top.map(|n| filling(n.clamp(1, MOST_CELLS)));
        let levels = std::array::from_fn(|k| {
            let fits = |l: &u32| {
                let cells = u64::from(top[k]) << l;
                cells <= u64::from(MOST_CELLS) && size[k] / cells as f64 >= smallest
            };
            (0..=MOST_LEVELS).take_while(fits).last().unwrap_or(0)
        });
        let cells = |k: usize| f64::from(top[k] << levels[k]);
        Self {
            low: bounds.min.to_array().map(S::to_f64),
            side: std::array::from_fn(|k| size[k] / cells(k)),
            top,
            levels,
        }
    }

    pub(super) fn whole(&self) -> Division {
        Division { first: [0; 3], shift: self.levels, parts: self.top }
    }

    /// Lattice cells on each axis.
    pub(super) fn resolution(&self) -> [u32; 3] {
        std::array::from_fn(|k| self.top[k] << self.levels[k])
    }

    /// World coordinate of lattice plane `i` of axis `k`.
    pub(super) fn plane(&self, k: usize, i: u32) -> f64 {
        self.low[k] + self.side[k] * f64::from(i)
    }
}

/// The number of cells nearest to `n` of which halvings make nearly as many as there may be: a
/// scene with all its detail in one place needs them.
fn filling(n: u32) -> u32 {
    let above = MOST_CELLS >> (MOST_CELLS / n).ilog2();
    let below = above / 2;
    if below > 0 && u64::from(n) * u64::from(n) < u64::from(above) * u64::from(below) {
        below
    } else {
        above
    }
}

/// Cells of a node of the tree, or of the top grid: a regular grid within the lattice.
#[derive(Debug, Clone, Copy)]
pub(super) struct Division {
    pub(super) first: [u32; 3],
    /// Lattice cells of a part, as a power of two.
    pub(super) shift: [u32; 3],
    /// Parts on each axis.
    pub(super) parts: [u32; 3],
}

impl Division {
    pub(super) fn count(&self) -> usize {
        self.parts.iter().map(|&n| n as usize).product()
    }

    /// First lattice cell of part `i`, x fastest.
    pub(super) fn part(&self, i: usize) -> [u32; 3] {
        let at = self.place(i);
        std::array::from_fn(|k| self.first[k] + (at[k] << self.shift[k]))
    }

    /// Coordinates of part `i`.
    pub(super) fn place(&self, i: usize) -> [u32; 3] {
        coords_of(i, self.parts)
    }
}

/// Coordinates of part `i` of so many, x fastest.
pub(super) fn coords_of(i: usize, parts: [u32; 3]) -> [u32; 3] {
    let [x, y, _] = parts.map(|n| n as usize);
    [i % x, i / x % y, i / x / y].map(|at| at as u32)
}
