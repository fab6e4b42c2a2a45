//! Finds the parts of a division that a triangle overlaps, exactly up to a margin.
//!
//! Paper: M. Schwarz, H.-P. Seidel, "Fast Parallel Surface and Solid Voxelization on GPUs", ACM TOG
//! 29(6), 2010: the separating axes of Akenine-Moeller (2001) for boxes of one size, set up once a
//! triangle.
//!
//! Deviations: in f64; each comparison has a slack above its rounding error, so that slivers whose
//! normal is mostly rounding lose no cell.

use glam::{DVec2, DVec3, dvec2};

/// Rounding errors of the expressions below are less than this many ulps of their largest term.
const SLACK_ULPS: f64 = 64.0;

/// A triangle against boxes of one size.
#[derive(Debug, Clone, Copy)]
pub(super) struct Overlap {
    corner: DVec3,
    normal: DVec3,
    /// `normal * (p - corner)` of the nearest and farthest corner of a box at `p` differ from that
    /// of `p` by these.
    plane: [f64; 2],
    /// For each pair of axes and each edge: inward normal, and the least value of
    /// `normal * (p - corner)` of a box that touches.
    edges: [[(DVec2, f64); 3]; 3],
}

impl Overlap {
    /// `corners` of the triangle and the boxes' `size`; boxes are no farther from the first corner
    /// than `reach` on any axis.
    pub(super) fn new(corners: [DVec3; 3], size: DVec3, reach: f64) -> Self {
        let [a, b, c] = corners;
        let sides = [b - a, c - b, a - c];
        let normal = sides[0].cross(sides[1]);
        let largest = sides.iter().fold(reach, |m, s| m.max(s.abs().max_element()));
        let slack = SLACK_ULPS * f64::EPSILON * largest * largest;
        let least = (normal * size).min(DVec3::ZERO).element_sum();
        let most = (normal * size).max(DVec3::ZERO).element_sum();
        let pair = |v: DVec3, i: usize| match i {
            0 => dvec2(v.x, v.y),
            1 => dvec2(v.y, v.z),
            _ => dvec2(v.z, v.x),
        };
        let edges = std::array::from_fn(|i| {
            let facing = [normal.z, normal.x, normal.y][i];
            std::array::from_fn(|e| {
                let side = pair(sides[e], i);
                let inward = dvec2(-side.y, side.x) * if facing < 0.0 { -1.0 } else { 1.0 };
                let gain = (inward * pair(size, i)).max(DVec2::ZERO).element_sum();
                (inward, inward.dot(pair(corners[e] - a, i)) - gain - slack)
            })
        });
        Self { corner: a, normal, plane: [least - slack * largest, most + slack * largest], edges }
    }

    /// Returns whether the box whose lower corner is `low` touches the triangle; its bounding box
    /// does.
    #[inline(always)]
    pub(super) fn touches(&self, low: DVec3) -> bool {
        let p = low - self.corner;
        let along = self.normal.dot(p);
        if along + self.plane[0] > 0.0 || along + self.plane[1] < 0.0 {
            return false;
        }
        let pairs = [dvec2(p.x, p.y), dvec2(p.y, p.z), dvec2(p.z, p.x)];
        (0..3).all(|i| self.edges[i].iter().all(|(inward, least)| inward.dot(pairs[i]) >= *least))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::structures::test_scenes::Random;

    /// Points of the triangle on a fine lattice, as an oracle that finds no overlap where none is.
    fn some_point_within(corners: [DVec3; 3], low: DVec3, high: DVec3) -> bool {
        (0..=60).flat_map(|i| (0..=60 - i).map(move |j| (f64::from(i), f64::from(j)))).any(
            |(i, j)| {
                let p = corners[0]
                    + (corners[1] - corners[0]) * (i / 60.0)
                    + (corners[2] - corners[0]) * (j / 60.0);
                p.cmpge(low).all() && p.cmple(high).all()
            },
        )
    }

    #[test]
    fn boxes_with_a_point_of_the_triangle_are_found_and_most_others_are_not() {
        let mut random = Random(11);
        let (mut touched, mut sampled, mut asked) = (0, 0, 0);
        for i in 0..60 {
            let mut corners = [0; 3].map(|_| random.point([1.0; 3]));
            if i % 5 == 0 {
                // slivers and triangles in a plane of the axes
                corners[2] = corners[0].lerp(corners[1], 0.3) + DVec3::X * 1e-12;
                corners[1].z = corners[0].z;
            }
            let size = DVec3::splat(0.125);
            let overlap = Overlap::new(corners, size, 2.0);
            let (lo, hi) = (
                corners[0].min(corners[1]).min(corners[2]),
                corners[0].max(corners[1]).max(corners[2]),
            );
            for cell in 0..512u32 {
                let at =
                    DVec3::new(f64::from(cell % 8), f64::from(cell / 8 % 8), f64::from(cell / 64));
                let low = at * size;
                if low.cmpgt(hi).any() || (low + size).cmplt(lo).any() {
                    continue;
                }
                asked += 1;
                let touches = overlap.touches(low);
                touched += usize::from(touches);
                if some_point_within(corners, low, low + size) {
                    sampled += 1;
                    assert!(touches, "{corners:?} {low}");
                }
            }
        }
        assert!(
            sampled > 500 && touched < sampled * 13 / 10 && asked > 2 * touched,
            "{sampled} {touched} {asked}"
        );
    }
}
