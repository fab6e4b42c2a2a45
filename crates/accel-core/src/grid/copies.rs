//! Scenes of which nearly all primitives lie where others do: cells do not separate those.

use crate::geometry::scalar::{Scalar, Vector};
use crate::primitives::Primitives;

/// References a primitive in a grid over copies, on average at most: a tree has each once.
pub(crate) const MOST_REFERENCES_A_COPY: u64 = 3;

/// Primitives looked at, and how many of them at first: most scenes have no copies.
const SAMPLE: usize = 1024;
const FIRST: usize = 64;

/// Whether a sample of many primitives has few boxes; false of few primitives.
pub(crate) fn are_copies<S: Scalar>(prims: &dyn Primitives<S>) -> bool {
    if prims.len() < 4 * SAMPLE {
        return false;
    }
    let distinct = |sample: usize| {
        let bits = |i: usize| {
            let bounds = prims.bounds((i * (prims.len() / sample)) as u32);
            [bounds.min, bounds.max].map(|p| p.to_dvec3().to_array().map(f64::to_bits))
        };
        let mut boxes: Vec<_> = (0..sample).map(bits).collect();
        boxes.sort_unstable();
        boxes.dedup();
        boxes.len()
    };
    // of 64 boxes that 64 places have in equal parts, 41 are distinct
    distinct(FIRST) * 4 <= FIRST * 3 && distinct(SAMPLE) * 16 <= SAMPLE
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::primitives::{TriangleSet, Watertight};

    /// So many triangles in turn at so many places.
    fn set(number: usize, places: usize) -> TriangleSet<f32, Watertight> {
        let triangle = |i: usize| {
            let x = (i * 7 % places) as f32;
            [[x, 0.0, 0.0], [x + 1.0, 0.0, 0.0], [x, 1.0, 1.0]]
        };
        TriangleSet::new((0..number).map(triangle).collect(), |_| false).unwrap()
    }

    #[test]
    fn many_triangles_at_few_places_are_copies() {
        assert!(are_copies(&set(10_000, 1)));
        assert!(are_copies(&set(10_000, 40)));
        assert!(!are_copies(&set(10_000, 3000)));
        assert!(!are_copies(&set(1000, 1)), "few of them");
    }
}
