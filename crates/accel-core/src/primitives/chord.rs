//! The hit of a ray with a polygon whose plane does not tell where it is.
//!
//! In the sheared space the ray is the z axis. Where it passes within an outline, the outline
//! crosses the plane y = 0 on both sides of it. The segment between the nearest two crossings lies
//! within the polygon and passes the ray, so that what is hit there lies in the convex hull of the
//! vertices whatever the angle. It is as precise as the crossings are far apart; where they are
//! not, all of the segment is equally near to the ray, and the plane may choose.

use crate::primitives::precise::signed_difference;

/// A crossing of an outline with the plane y = 0.
#[derive(Debug, Clone, Copy)]
struct Crossing {
    x: f64,
    depth: f64,
}

/// The segment of a polygon that passes the axis.
#[derive(Debug, Clone, Copy)]
pub(super) struct Chord {
    /// At x <= 0.
    left: Crossing,
    /// At x > 0.
    right: Crossing,
}

impl Chord {
    /// That of an outline by the even-odd rule, none if the axis is outside.
    pub(super) fn of(outline: impl Iterator<Item = [f64; 3]> + Clone) -> Option<Self> {
        let mut p = outline.clone().last()?;
        let mut is_inside = false;
        let mut left = Crossing { x: f64::NEG_INFINITY, depth: 0.0 };
        let mut right = Crossing { x: f64::INFINITY, depth: 0.0 };
        for q in outline {
            if (p[1] > 0.0) != (q[1] > 0.0) {
                let side = signed_difference(p[0], q[1], q[0], p[1]);
                let weight = p[1] / (p[1] - q[1]);
                let depth = p[2] * (1.0 - weight) + q[2] * weight;
                let at = Crossing { x: side / (q[1] - p[1]), depth };
                let is_right = side != 0.0 && (side > 0.0) == (q[1] > p[1]);
                is_inside ^= is_right;
                let nearest = if is_right { &mut right } else { &mut left };
                if at.x.abs() < nearest.x.abs() {
                    *nearest = at;
                }
            }
            p = q;
        }
        is_inside.then_some(Self { left, right })
    }

    /// The depth on the axis: that of the plane, as far as a point of the segment lies so near.
    pub(super) fn depth_near(&self, plane: f64, rounding: f64) -> f64 {
        let Self { left, right } = self;
        let width = right.x - left.x;
        let rise = right.depth - left.depth;
        // both may be so near that their distance is zero
        let weight = if width > 0.0 { -left.x / width } else { 0.5 };
        let depth = left.depth + rise * weight;
        let slack = if width > 0.0 { rounding * rise.abs() / width } else { f64::INFINITY };
        let least = (depth - slack).max(left.depth.min(right.depth));
        let most = (depth + slack).min(left.depth.max(right.depth));
        if plane.is_nan() { depth } else { plane.max(least).min(most) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chord(outline: &[[f64; 3]]) -> Option<Chord> {
        Chord::of(outline.iter().copied())
    }

    #[test]
    fn the_depth_is_that_of_the_segment_through_the_axis() {
        let slanted = [[-2.0, -1.0, 0.0], [6.0, -1.0, 8.0], [6.0, 1.0, 8.0], [-2.0, 1.0, 0.0]];
        let through = chord(&slanted).unwrap();
        for (plane, depth) in [(2.0, 2.0), (9.0, 2.5), (-9.0, 1.5), (f64::NAN, 2.0), (2.1, 2.1)] {
            assert_eq!(through.depth_near(plane, 0.5), depth, "{plane}");
        }
        assert!(chord(&slanted.map(|[x, y, z]| [x + 3.0, y, z])).is_none());
    }

    #[test]
    fn the_plane_chooses_within_an_outline_that_is_seen_edge_on() {
        let least = f64::from_bits(1);
        let thin = [[0.0, -1.0, 3.0], [least, -1.0, 3.0], [least, 1.0, 7.0], [0.0, 1.0, 7.0]];
        let through = chord(&thin).unwrap();
        for (plane, depth) in [(5.5, 5.0), (-4.0, 5.0), (f64::INFINITY, 5.0)] {
            assert_eq!(through.depth_near(plane, 1e-9), depth);
        }
        let bent = [[0.0, -1.0, 3.0], [least, -1.0, 5.0], [least, 1.0, 7.0], [0.0, 1.0, 3.0]];
        let through = chord(&bent).unwrap();
        for (plane, depth) in [(5.5, 5.5), (-4.0, 3.0), (f64::INFINITY, 6.0)] {
            assert_eq!(through.depth_near(plane, 1e-9), depth);
        }
    }
}
