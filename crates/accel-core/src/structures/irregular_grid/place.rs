//! Assigns primitives to the parts of a division.

use std::ops::Range;

use glam::DVec3;

use crate::parallel;
use crate::structures::irregular_grid::lattice::{Division, Lattice};
use crate::structures::irregular_grid::overlap::Overlap;

/// The input of a build, independent of scalar and primitive set.
pub(super) trait Source {
    fn len(&self) -> u32;
    /// The padded box of a primitive.
    fn bounds(&self, id: u32) -> (DVec3, DVec3);
    /// The corners of one that is a triangle at rest.
    fn triangle(&self, id: u32) -> Option<[DVec3; 3]>;
    /// Returns whether another touches the box between these corners.
    fn overlaps(&self, id: u32, low: DVec3, high: DVec3) -> bool;
    /// By how much boxes are padded.
    fn margin(&self) -> f64;
}

/// Boxes that meet more cells of the top grid than this on average are nearly all in the same
/// place.
const MOST_TOP_CELLS: f64 = 16.0;

pub(super) type Pair = (u32, u32);

/// Number of ids placed at a time.
const CHUNK: usize = 1 << 13;

/// Primitives and the lattice that they are placed on.
#[derive(Clone, Copy)]
pub(super) struct Placement<'a> {
    pub(super) lattice: &'a Lattice,
    pub(super) source: &'a (dyn Source + Sync),
}

impl Placement<'_> {
    /// Returns whether the boxes of the primitives meet few cells of the top grid each, on average.
    pub(super) fn is_sparse(&self) -> bool {
        let whole = self.lattice.whole();
        let cells = |id: u32| {
            let (first, last) = self.met(id, &whole);
            (0..3).map(|k| f64::from(last[k] - first[k] + 1)).product::<f64>()
        };
        let met =
            parallel::map_parts(self.source.len() as usize, |ids| ids.map(cells).sum::<f64>());
        met.iter().sum::<f64>() <= MOST_TOP_CELLS * f64::from(self.source.len())
    }

    /// The first and last part, on each axis, that the box of a primitive meets.
    fn met(&self, id: u32, division: &Division) -> ([u32; 3], [u32; 3]) {
        let along = |k: usize, x: f64| {
            let side = self.lattice.side[k] * f64::from(1u32 << division.shift[k]);
            let at = (x - self.lattice.plane(k, division.first[k])) / side;
            at.clamp(0.0, f64::from(division.parts[k] - 1)) as u32
        };
        let (low, high) = self.source.bounds(id);
        (std::array::from_fn(|k| along(k, low[k])), std::array::from_fn(|k| along(k, high[k])))
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
        let (lattice, margin) = (self.lattice, self.source.margin());
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
            let overlap = self.source.triangle(id).map(|corners| {
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
                            None => self.source.overlaps(id, at, at + size),
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

/// End of the ids of each part; ids are in the order of parts.
pub(super) struct RangeEnds(Vec<usize>);

impl RangeEnds {
    /// Appends the ids of pairs in the order of their parts, those of a part in the order of the
    /// pairs. Ends are counted from the first that is appended.
    pub(super) fn sort<'p>(
        parts: usize,
        pairs: impl Iterator<Item = &'p Pair> + Clone,
        ids: &mut Vec<u32>,
    ) -> Self {
        let mut ends = vec![0usize; parts + 1];
        for &(part, _) in pairs.clone() {
            ends[part as usize + 1] += 1;
        }
        for i in 0..parts {
            ends[i + 1] += ends[i];
        }
        let base = ids.len();
        ids.resize(base + ends[parts], 0);
        for &(part, id) in pairs {
            // the beginning of a part becomes its end
            let at = &mut ends[part as usize];
            ids[base + *at] = id;
            *at += 1;
        }
        Self(ends)
    }

    /// Range of the ids of a part.
    pub(super) fn of(&self, part: usize) -> Range<usize> {
        part.checked_sub(1).map_or(0, |before| self.0[before])..self.0[part]
    }
}
