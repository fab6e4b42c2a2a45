//! Region of a cell that shows a primitive, in one word: bounds of u, v, u + v and u - v.
//!
//! A cell is thought of as 128 x 128 spots. Whether the spot that a ray passes lies within the
//! bounds of a primitive is one subtraction, as all eight comparisons are made at once, a byte
//! each (L. Lamport, "Multiple Byte Processing with Full-Word Instructions", CACM 18(8), 1975).
//! The bounds along the diagonals are those of J. Klosowski et al., "Efficient Collision Detection
//! Using Bounding Volume Hierarchies of k-DOPs", IEEE TVCG 4(1), 1998, with k = 8.

use glam::DVec2;

use crate::occluders::light_buffer::footprint::HalfPlane;

/// A spot is this many bits of u and of v below its cell.
pub(super) const SPOT_BITS: u32 = 7;
/// Spots of a cell along u or v.
const SPOTS: u32 = 1 << SPOT_BITS;
/// The highest bit of each byte.
const HIGH: u64 = 0x8080_8080_8080_8080;
/// Seven bits in each of four bytes.
const SEVEN: u32 = 0x7f7f_7f7f;
/// By how many spots bounds grow against the rounding of what they are made from.
const SLACK: f64 = 1e-6;
/// Outlines of half as many spots are not cut.
const SMALL: f64 = 2.0;

/// Point at which a ray passes through a cell.
#[derive(Debug, Clone, Copy)]
pub(super) struct CellPoint(u64);

impl CellPoint {
    /// From coordinates whose lowest [`SPOT_BITS`] bits are those within the cell.
    #[inline(always)]
    pub(super) fn of(x: u32, y: u32) -> Self {
        let (x, y) = (x & (SPOTS - 1), y & (SPOTS - 1));
        let along = x | y << 8 | ((x + y) >> 1) << 16 | ((x + SPOTS - y) >> 1) << 24;
        Self(u64::from(SEVEN - along) << 32 | u64::from(along) | HIGH)
    }
}

/// A part of a cell: for each of four directions the least that a spot may have there, and 127
/// less the most.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct CellRegion(u64);

impl CellRegion {
    pub(super) const ALL: Self = Self(0);

    /// Returns whether the spot may show what the part was made from.
    #[inline(always)]
    pub(super) fn holds(self, spot: CellPoint) -> bool {
        // each byte of the difference keeps its highest bit where it is not below
        spot.0.wrapping_sub(self.0) & HIGH == HIGH
    }

    /// Around points given in spots from the lowest corner of the cell.
    fn around(points: &[DVec2]) -> Self {
        let bounds = |along: fn(&DVec2) -> f64| {
            points.iter().map(along).fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), x| {
                (lo.min(x - SLACK), hi.max(x + SLACK))
            })
        };
        if points.is_empty() || !points.iter().all(|p| p.is_finite()) {
            return Self::ALL;
        }
        let floor = |x: f64| x.floor() as i64;
        let (u, v) = (bounds(|p| p.x), bounds(|p| p.y));
        let (sum, difference) = (bounds(|p| p.x + p.y), bounds(|p| p.x - p.y));
        let spots = i64::from(SPOTS);
        // the spot of a point has rounded coordinates: their sum is up to 1 less than that of the
        // point's, their difference up to 1 more
        let along = [
            (floor(u.0), floor(u.1)),
            (floor(v.0), floor(v.1)),
            ((floor(sum.0) - 1) >> 1, floor(sum.1) >> 1),
            ((floor(difference.0) + spots) >> 1, (floor(difference.1) + 1 + spots) >> 1),
        ];
        let mut word = 0;
        for (i, (lo, hi)) in along.into_iter().enumerate() {
            let within = |x: i64| x.clamp(0, spots - 1) as u64;
            word |= within(lo) << (8 * i) | (spots as u64 - 1 - within(hi)) << (8 * i + 32);
        }
        Self(word)
    }
}

/// Cuts outlines; keeps its memory.
#[derive(Debug, Default)]
pub(super) struct OutlineClipper {
    points: Vec<DVec2>,
    kept: Vec<DVec2>,
}

impl OutlineClipper {
    /// The part of the cell from `low`, a spot as large as `spot`, in which a convex outline is
    /// seen: a rectangle cut by half-planes (I. Sutherland, G. Hodgman, "Reentrant Polygon
    /// Clipping", CACM 17(1), 1974).
    pub(super) fn part(
        &mut self,
        rectangle: [DVec2; 2],
        sides: &[HalfPlane],
        low: DVec2,
        spot: DVec2,
    ) -> CellRegion {
        let size = spot * f64::from(SPOTS);
        let (from, to) = (rectangle[0].max(low), rectangle[1].min(low + size));
        self.points.clear();
        self.points.extend([from, DVec2::new(to.x, from.y), to, DVec2::new(from.x, to.y)]);
        let (center, half) = ((from + to) * 0.5, (to - from) * 0.5);
        // within few spots a rectangle says as much as the outline
        let is_small = half.cmplt(spot * SMALL).all();
        for side in if is_small { &[] } else { sides } {
            // most cut nothing off
            if side.normal.dot(center) + side.normal.abs().dot(half) > side.limit {
                self.cut(side);
            }
        }
        let scale = 1.0 / spot;
        for p in &mut self.points {
            *p = (*p - low) * scale;
        }
        CellRegion::around(&self.points)
    }

    fn cut(&mut self, side: &HalfPlane) {
        let Some(last) = self.points.last() else { return };
        let beyond = |p: DVec2| side.normal.dot(p) - side.limit;
        let mut before = (*last, beyond(*last));
        self.kept.clear();
        for &point in &self.points {
            let d = beyond(point);
            if (d > 0.0) != (before.1 > 0.0) {
                self.kept.push(before.0.lerp(point, before.1 / (before.1 - d)));
            }
            if d <= 0.0 {
                self.kept.push(point);
            }
            before = (point, d);
        }
        std::mem::swap(&mut self.points, &mut self.kept);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::structures::test_scenes::Random;
    use glam::dvec2;

    /// Random triangles, in part beyond the cell, as half-planes; and whether points of them are
    /// held, and how many of the others are not.
    #[test]
    fn a_cell_region_holds_its_outline_and_few_other_points() {
        let mut random = Random(9);
        let (mut within, mut refused, mut kept) = (0, 0, 0);
        let mut clip = OutlineClipper::default();
        for round in 0..400 {
            let size = if round % 2 == 0 { 0.1 } else { 2.0 };
            let mut point = || dvec2(random.unit(), random.unit()) * size - size * 0.3;
            let (low, spot) = (dvec2(0.0, 0.0), DVec2::splat(0.5 / 128.0));
            let mut corners = [point(), point(), point()];
            if (corners[1] - corners[0]).perp_dot(corners[2] - corners[0]) < 0.0 {
                corners.swap(1, 2);
            }
            let sides: Vec<HalfPlane> = (0..3)
                .map(|i| {
                    let normal = -(corners[(i + 1) % 3] - corners[i]).perp().normalize();
                    HalfPlane { normal, limit: normal.dot(corners[i]) }
                })
                .collect();
            let bounds = corners.iter().fold([corners[0]; 2], |[l, h], p| [l.min(*p), h.max(*p)]);
            if bounds[0].max_element() > 0.5 || bounds[1].min_element() < 0.0 {
                continue;
            }
            let part = clip.part(bounds, &sides, low, spot);
            for _ in 0..200 {
                let p = dvec2(random.unit(), random.unit()) * 0.5;
                let (x, y) = ((p.x / spot.x) as u32, (p.y / spot.y) as u32);
                let held = part.holds(CellPoint::of(x + 128 * 7, y + 128 * 3));
                if sides.iter().all(|s| s.normal.dot(p) <= s.limit) {
                    within += 1;
                    assert!(held, "{corners:?} {p}");
                } else {
                    refused += usize::from(!held);
                    kept += usize::from(held);
                }
            }
        }
        assert!(within > 3000 && refused > kept * 4, "{within} {refused} {kept}");
    }

    #[test]
    fn the_whole_cell_holds_every_spot_and_a_planted_fault_is_caught() {
        let corners = [(0, 0), (0, 127), (127, 0), (127, 127), (64, 3)];
        assert!(corners.iter().all(|&(x, y)| CellRegion::ALL.holds(CellPoint::of(x, y))));
        let all = CellRegion::around(&[
            DVec2::ZERO,
            dvec2(128.0, 128.0),
            dvec2(0., 128.),
            dvec2(128., 0.),
        ]);
        assert_eq!(all, CellRegion::ALL);
        assert_eq!(CellRegion::around(&[DVec2::NAN]), CellRegion::ALL);
        // bounds that are too narrow by a spot lose the corners
        let narrow = CellRegion::around(&[dvec2(1.5, 1.5), dvec2(126.5, 126.5)]);
        let lost = |&&(x, y): &&(u32, u32)| !narrow.holds(CellPoint::of(x, y));
        assert_eq!(corners.iter().filter(lost).count(), 5);
        assert!(narrow.holds(CellPoint::of(60, 61)));
    }
}
