//! Assigns primitives to the parts of a division.

use glam::DVec3;

use crate::geometry::aabb::Aabb;
use crate::geometry::scalar::{Scalar, Vector};
use crate::grid::cell_overlap;
use crate::historical::bounds_rule::BoundsOf;
use crate::parallel;
use crate::structures::irregular_grid::lattice::{Division, Lattice};
use crate::structures::irregular_grid::overlap::Overlap;

/// Boxes that meet more cells of the top grid than this on average are nearly all in the same
/// place.
const MOST_TOP_CELLS: f64 = 16.0;

pub(super) type Pair = (u32, u32);

/// Number of ids placed at a time.
const CHUNK: usize = 1 << 13;

/// The padded boxes of primitives, and the lattice that they are placed on.
#[derive(Clone, Copy)]
pub(super) struct Placement<'a, S: Scalar> {
    pub(super) lattice: &'a Lattice,
    pub(super) boxes: &'a BoundsOf<'a, S>,
}

impl<S: Scalar> Placement<'_, S> {
    pub(super) fn primitives(&self) -> usize {
        self.boxes.prims().len()
    }

    /// Returns whether the boxes of the primitives meet few cells of the top grid each, on average.
    pub(super) fn is_sparse(&self) -> bool {
        let whole = self.lattice.whole();
        let cells = |id: u32| {
            let (first, last) = self.met(id, &whole);
            (0..3).map(|k| f64::from(last[k] - first[k] + 1)).product::<f64>()
        };
        let met = parallel::map_parts(self.primitives(), |ids| ids.map(cells).sum::<f64>());
        met.iter().sum::<f64>() <= MOST_TOP_CELLS * self.primitives() as f64
    }

    /// The first and last part, on each axis, that the box of a primitive meets.
    fn met(&self, id: u32, division: &Division) -> ([u32; 3], [u32; 3]) {
        let along = |k: usize, x: f64| {
            let side = self.lattice.side[k] * f64::from(1u32 << division.shift[k]);
            let at = (x - self.lattice.plane(k, division.first[k])) / side;
            at.clamp(0.0, f64::from(division.parts[k] - 1)) as u32
        };
        let Aabb { min, max } = self.boxes.of(id).in_double();
        (std::array::from_fn(|k| along(k, min[k])), std::array::from_fn(|k| along(k, max[k])))
    }

    /// The parts that each of these ids goes to, ids ascending.
    pub(super) fn place_all(&self, ids: &[u32], division: &Division) -> Vec<Vec<Pair>> {
        let part = |ids: &[u32]| {
            let mut pairs = Vec::with_capacity(ids.len() * 2);
            self.place(ids, division, &mut pairs);
            pairs
        };
        parallel::map(ids.chunks(CHUNK), &part)
    }

    /// Fills `pairs` with the parts that each of these ids goes to, ids ascending.
    pub(super) fn place(&self, ids: &[u32], division: &Division, pairs: &mut Vec<Pair>) {
        let (lattice, margin) = (self.lattice, self.boxes.padding().to_f64());
        let prims = self.boxes.prims();
        let [nx, ny, _] = division.parts;
        let low = DVec3::from_array(std::array::from_fn(|k| {
            lattice.plane(k, division.first[k]) - margin
        }));
        let side = DVec3::from_array(std::array::from_fn(|k| {
            lattice.side[k] * f64::from(1u32 << division.shift[k])
        }));
        let size = side + 2.0 * margin;
        pairs.clear();
        for &id in ids {
            let (first, last) = self.met(id, division);
            let index = |x: u32, y: u32, z: u32| x + nx * (y + ny * z);
            if first == last {
                pairs.push((index(first[0], first[1], first[2]), id));
                continue;
            }
            let overlap = prims.corners(id).map(|corners| {
                let corners = corners.map(|p| p.to_dvec3());
                let far = DVec3::from_array(division.parts.map(f64::from)) * side + 2.0 * margin;
                let reach = (low - corners[0]).abs().max((low + far - corners[0]).abs());
                Overlap::new(corners, size, reach.max_element())
            });
            for z in first[2]..=last[2] {
                for y in first[1]..=last[1] {
                    for x in first[0]..=last[0] {
                        let at = low + DVec3::new(x.into(), y.into(), z.into()) * side;
                        let touches = match &overlap {
                            Some(overlap) => overlap.touches(at),
                            None => {
                                cell_overlap::overlaps(prims, id, (at, at + size), &mut Vec::new())
                            }
                        };
                        if touches {
                            pairs.push((index(x, y, z), id));
                        }
                    }
                }
            }
        }
    }
}
