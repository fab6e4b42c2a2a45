//! Share of the unit disc covered by a shape: exact areas and centroids.
//!
//! Paper: J. Amanatides, "Ray Tracing with Cones", SIGGRAPH 1984, which estimates these areas by
//! tables and lines. Deviation: they are exact. The disc and a polygon: by the signed sum over its
//! edges of what the disc shares with the triangle of an edge and the centre, which holds for
//! concave outlines, too. Two discs: two circular segments; the first moment of both about the
//! centre of the unit disc is the distance d of the centres times the area of the other's segment,
//! since the chord's own terms, 2/3 h^3 each, cancel.

use std::f64::consts::PI;

use glam::DVec2;

/// Shares below this are nothing, shares above one less this are all: far beyond what an image
/// shows, far above the rounding of the areas.
const NOTHING: f64 = 1e-10;

/// The part of the unit disc that is covered.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Overlap {
    /// Its area over that of the disc, in [0, 1].
    pub share: f64,
    /// Its centroid; the centre of the disc where nothing is covered.
    pub centroid: DVec2,
}

impl Overlap {
    pub const NONE: Self = Self { share: 0.0, centroid: DVec2::ZERO };
    pub const ALL: Self = Self { share: 1.0, centroid: DVec2::ZERO };

    /// From an area and its first moment about the centre of the disc.
    fn new(area: f64, moment: DVec2) -> Self {
        let share = area / PI;
        if share >= 1.0 - NOTHING {
            return Self::ALL;
        }
        // NaN: a corner that is not finite
        if share.is_nan() || share <= NOTHING {
            return Self::NONE;
        }
        // rounding of the moments of slivers must not leave the disc
        Self { share, centroid: (moment / area).clamp_length_max(1.0) }
    }
}

/// With a polygon, concave ones too, in either orientation.
pub fn of_polygon(corners: &[DVec2]) -> Overlap {
    let Some(&last) = corners.last() else { return Overlap::NONE };
    if !corners.iter().all(|p| p.is_finite()) {
        return Overlap::NONE;
    }
    let (mut area, mut moment) = (0.0, DVec2::ZERO);
    let mut from = last;
    for &to in corners {
        let (a, m) = of_edge(from, to);
        area += a;
        moment += m;
        from = to;
    }
    if area < 0.0 { Overlap::new(-area, -moment) } else { Overlap::new(area, moment) }
}

/// Signed area and first moment of the disc's part of the triangle of an edge and the centre.
fn of_edge(p: DVec2, q: DVec2) -> (f64, DVec2) {
    let d = q - p;
    let (a, b, c) = (d.length_squared(), p.dot(d), p.length_squared() - 1.0);
    let discriminant = b * b - a * c;
    // NaN or no length: nothing but a sector
    if discriminant.is_nan() || discriminant <= 0.0 || a == 0.0 {
        return sector(p, q);
    }
    let root = discriminant.sqrt();
    let (enter, leave) = ((-b - root) / a, (root - b) / a);
    if enter >= 1.0 || leave <= 0.0 {
        return sector(p, q);
    }
    let mut sum = (0.0, DVec2::ZERO);
    let mut add = |(area, moment): (f64, DVec2)| {
        sum.0 += area;
        sum.1 += moment;
    };
    let first = if enter > 0.0 { p + d * enter } else { p };
    let second = if leave < 1.0 { p + d * leave } else { q };
    if enter > 0.0 {
        add(sector(p, first));
    }
    let twice = first.perp_dot(second);
    add((twice / 2.0, (first + second) * (twice / 6.0)));
    if leave < 1.0 {
        add(sector(second, q));
    }
    sum
}

/// The sector between the directions of two points.
fn sector(p: DVec2, q: DVec2) -> (f64, DVec2) {
    let (Some(a), Some(b)) = (p.try_normalize(), q.try_normalize()) else {
        return (0.0, DVec2::ZERO);
    };
    let angle = a.perp_dot(b).atan2(a.dot(b));
    (angle / 2.0, DVec2::new(b.y - a.y, a.x - b.x) / 3.0)
}

pub fn of_disc(center: DVec2, radius: f64) -> Overlap {
    let distance = center.length();
    if radius.is_nan() || radius <= 0.0 || distance.is_nan() || distance >= 1.0 + radius {
        return Overlap::NONE;
    }
    if distance <= radius - 1.0 {
        return Overlap::ALL;
    }
    if distance <= 1.0 - radius {
        let area = PI * radius * radius;
        return Overlap::new(area, center * area);
    }
    // the chord, from the centre of the unit disc and from the other
    let here =
        (((distance - radius) * (distance + radius) + 1.0) / (2.0 * distance)).clamp(-1.0, 1.0);
    let there = ((distance - here) / radius).clamp(-1.0, 1.0);
    let own = segment(here);
    let other = radius * radius * segment(there);
    Overlap::new(own + other, center * other)
}

/// Area of the unit disc beyond a chord at a signed distance from its centre.
fn segment(distance: f64) -> f64 {
    distance.acos() - distance * (1.0 - distance * distance).max(0.0).sqrt()
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::tracers::cone::coverage::Outline;

    /// Share and centroid by counting the cells of a grid of `n` by `n`.
    pub fn counted(n: u32, holds: impl Fn(DVec2) -> bool) -> (f64, DVec2) {
        let (mut all, mut inside, mut sum) = (0, 0, DVec2::ZERO);
        for i in 0..n * n {
            let cell = DVec2::new(f64::from(i % n), f64::from(i / n)) + 0.5;
            let p = cell * (2.0 / f64::from(n)) - 1.0;
            if p.length_squared() <= 1.0 {
                all += 1;
                if holds(p) {
                    inside += 1;
                    sum += p;
                }
            }
        }
        (f64::from(inside) / f64::from(all), sum / f64::from(inside.max(1)))
    }

    fn agrees(found: Overlap, (share, centroid): (f64, DVec2), planted: f64) -> bool {
        (found.share * planted - share).abs() < 0.003
            && (share < 0.01 || found.centroid.distance(centroid) < 0.01)
    }

    #[test]
    fn areas_are_those_of_numerical_integration() {
        let v = DVec2::new;
        let outlines: [&[DVec2]; 6] = [
            &[v(-0.2, -0.3), v(0.5, -0.1), v(0.1, 0.6)],
            &[v(-3.0, -0.3), v(5.0, 0.1), v(0.1, 6.0)],
            &[v(0.3, -9.0), v(9.0, -9.0), v(9.0, 9.0), v(0.3, 9.0)],
            // concave, both ways around
            &[v(-1.5, -0.8), v(1.2, -0.9), v(0.1, -0.1), v(0.2, 1.4)],
            &[v(0.2, 1.4), v(0.1, -0.1), v(1.2, -0.9), v(-1.5, -0.8)],
            &[v(-0.9, -0.9), v(0.9, -0.9), v(0.9, 0.9), v(0.0, -0.7), v(-0.9, 0.9)],
        ];
        for corners in outlines {
            let outline = Outline::Polygon(corners.to_vec());
            let expected = counted(600, |p| outline.covers(p));
            assert!(agrees(of_polygon(corners), expected, 1.0), "{corners:?} {expected:?}");
            assert!(!agrees(of_polygon(corners), expected, 1.1), "no power: {expected:?}");
        }
        for (x, y, radius) in [
            (0.3, 0.1, 0.4),
            (0.7, -0.2, 0.6),
            (1.2, 0.9, 0.8),
            (-3.0, 2.0, 3.5),
            (0.0, 40.1, 40.0),
        ] {
            let center = v(x, y);
            let expected = counted(600, |p| p.distance(center) <= radius);
            let found = of_disc(center, radius);
            assert!(agrees(found, expected, 1.0), "{center} {radius}: {found:?} {expected:?}");
        }
    }

    #[test]
    fn overlaps_of_covering_distant_and_touching_polygons() {
        let square = |h: f64| [(-h, -h), (h, -h), (h, h), (-h, h)].map(DVec2::from);
        assert_eq!(of_polygon(&square(1.0)), Overlap::ALL);
        assert_eq!(of_polygon(&square(1e9)), Overlap::ALL);
        assert_eq!(of_polygon(&square(2.0).map(|p| p + DVec2::X * 3.0)), Overlap::NONE);
        assert!((of_polygon(&square(0.5)).share - 1.0 / PI).abs() < 1e-15);
        assert_eq!(of_polygon(&[]), Overlap::NONE);
        assert_eq!(of_polygon(&[DVec2::NAN, DVec2::X, DVec2::Y]), Overlap::NONE);
        assert_eq!(of_disc(DVec2::ZERO, 1.0), Overlap::ALL);
        assert_eq!(of_disc(DVec2::X * 2.0, 1.0), Overlap::NONE);
        assert_eq!(of_disc(DVec2::X * 1e6, 1e6 + 1.0), Overlap::ALL);
        assert!((of_disc(DVec2::X * 1e6, 1e6).share - 0.5).abs() < 1e-6);
        assert_eq!(of_disc(DVec2::ZERO, f64::NAN), Overlap::NONE);
    }
}
