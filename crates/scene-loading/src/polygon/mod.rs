//! Planar polygons: normal, flatness, and triangles. Flat outlines that cross themselves are cut at
//! the crossings into loops that do not.

pub(crate) mod ear_clipping;
mod point_tree;

use glam::{DVec2, DVec3};

use crate::polygon::ear_clipping::triangulate;
use crate::polygon::point_tree::orientation;

/// Corners may lie off the plane of their polygon by this share of its extent.
const FLATNESS: f64 = 1e-4;

/// Areas below this share of the squared extent count as zero.
const ZERO_AREA: f64 = 1e-15;

/// Outlines of more corners are not looked at: every edge is compared with every other.
const MAX_CROSSING_CORNERS: usize = 16;

/// Kind of the outline of a face.
#[derive(Debug)]
pub(crate) enum Outline {
    /// All corners lie in one plane. It may have more than 16 corners and cross itself.
    Flat,
    /// They do not; this is the area vector.
    Bent(DVec3),
    /// It crosses itself: the triangles that it encloses.
    Crossing(Vec<[DVec3; 3]>),
    /// A corner is NaN.
    Unusable,
    WithoutArea,
}

impl Outline {
    pub fn of(corners: &[DVec3]) -> Self {
        let crossing = || split_at_crossings(corners).filter(|all| !all.is_empty());
        match area_vector(corners) {
            Some(_) if corners.len() == 3 => Self::Flat,
            Some(area) if !is_flat(corners, area) => Self::Bent(area),
            Some(_) if !may_cross(corners) => Self::Flat,
            Some(_) => crossing().map_or(Self::Flat, Self::Crossing),
            None if corners.iter().any(|corner| corner.is_nan()) => Self::Unusable,
            // halves that are equal cancel
            None => crossing().map_or(Self::WithoutArea, Self::Crossing),
        }
    }

    /// True where a face has any area, as far as it can be told.
    pub fn has_area(&self) -> bool {
        !matches!(self, Self::Unusable | Self::WithoutArea)
    }
}

/// The area vector of a polygon (Newell's method): normal to it, as long as its area. `None` for
/// a polygon without area.
pub(crate) fn area_vector(corners: &[DVec3]) -> Option<DVec3> {
    let origin = *corners.first()?;
    let mut sum = DVec3::ZERO;
    let mut extent: f64 = 0.0;
    for pair in corners.windows(2) {
        let [a, b] = pair else { continue };
        let (a, b) = (*a - origin, *b - origin);
        sum += a.cross(b);
        extent = extent.max(b.abs().max_element());
    }
    let area = sum * 0.5;
    (area.length() > ZERO_AREA * extent * extent).then_some(area)
}

/// True when all corners lie in one plane, within [`FLATNESS`] of the polygon's extent.
pub(crate) fn is_flat(corners: &[DVec3], area: DVec3) -> bool {
    let normal = area.normalize_or_zero();
    let center = corners.iter().sum::<DVec3>() / corners.len().max(1) as f64;
    let mut extent: f64 = 0.0;
    let mut off: f64 = 0.0;
    for corner in corners {
        extent = extent.max(corner.distance(center));
        off = off.max((*corner - center).dot(normal).abs());
    }
    off <= FLATNESS * extent
}

/// True for a quadrangle that is concave at its first or third corner, or crosses itself: those two
/// lie on one side of the line through the others.
fn may_cross(corners: &[DVec3]) -> bool {
    let &[a, b, c, d] = corners else { return false };
    (b - a).cross(c - a).dot((c - a).cross(d - a)) < 0.0
}

/// The triangles of a flat outline that crosses itself; crossings become corners. None where it
/// does not, or has more than 16 corners.
fn split_at_crossings(corners: &[DVec3]) -> Option<Vec<[DVec3; 3]>> {
    if !(4..=MAX_CROSSING_CORNERS).contains(&corners.len()) {
        return None;
    }
    let normal = normal(corners)?;
    if !is_flat(corners, normal) {
        return None;
    }
    let axis = normal.abs().max_position();
    let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
    let origin = *corners.first()?;
    let flat = |p: DVec3| DVec2::new(p[u] - origin[u], p[v] - origin[v]);
    let mut uncut = vec![corners.to_vec()];
    let mut loops: Vec<Vec<DVec3>> = Vec::new();
    let mut cuts = 0;
    while let Some(outline) = uncut.pop() {
        // a simple outline has no crossing; rounding must not make ever more of them
        match first_crossing(&outline, flat).filter(|_| cuts < 2 * MAX_CROSSING_CORNERS) {
            Some((i, j, point)) => {
                cuts += 1;
                let inner = std::iter::once(point).chain(outline[i + 1..=j].iter().copied());
                let outer = outline[..=i].iter().chain([&point]).chain(&outline[j + 1..]);
                uncut.push(outer.copied().collect());
                uncut.push(inner.collect());
            }
            None => loops.push(outline),
        }
    }
    if cuts == 0 {
        return None;
    }
    let mut triangles = Vec::new();
    for outline in loops.iter().filter(|outline| area_vector(outline).is_some()) {
        for triangle in triangulate(outline).ok()? {
            let triangle = triangle.map(|i| outline[i as usize]);
            triangles.extend(area_vector(&triangle).map(|_| triangle));
        }
    }
    Some(triangles)
}

/// A normal of a flat outline, whatever it encloses; none where its corners lie in a line.
fn normal(corners: &[DVec3]) -> Option<DVec3> {
    let origin = *corners.first()?;
    let crosses = corners.windows(2).map(|pair| (pair[0] - origin).cross(pair[1] - origin));
    let largest = crosses.max_by(|a, b| a.length_squared().total_cmp(&b.length_squared()))?;
    let extent = corners.iter().map(|p| p.distance(origin)).fold(0.0, f64::max);
    (largest.length() > ZERO_AREA * extent * extent).then_some(largest)
}

/// Two edges that cross in their middles, by their first corners, and where.
fn first_crossing(
    outline: &[DVec3],
    flat: impl Fn(DVec3) -> DVec2,
) -> Option<(usize, usize, DVec3)> {
    let n = outline.len();
    let points: Vec<DVec2> = outline.iter().map(|&p| flat(p)).collect();
    let differ = |a: f64, b: f64| (a > 0.0 && b < 0.0) || (a < 0.0 && b > 0.0);
    for i in 0..n {
        for j in i + 2..n {
            let ([a, b], [c, d]) = ([points[i], points[i + 1]], [points[j], points[(j + 1) % n]]);
            let (from, to) = (orientation(c, d, a), orientation(c, d, b));
            if differ(from, to) && differ(orientation(a, b, c), orientation(a, b, d)) {
                let at = outline[i].lerp(outline[i + 1], from / (from - to));
                return Some((i, j, at));
            }
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn polygons_without_area() {
        let x = DVec3::X;
        assert_eq!(area_vector(&[x, x, x]), None);
        assert_eq!(area_vector(&[x * 0.1, x * 0.3, x * 0.7]), None);
        let needle = [DVec3::ZERO, x * 1e4, DVec3::Y * 1e-4];
        assert!(area_vector(&needle).is_some());
    }

    #[test]
    fn bent_quadrangles_are_not_flat() {
        let bent = |h: f64| [DVec3::ZERO, DVec3::X, DVec3::new(1.0, 1.0, h), DVec3::Y];
        let flat = |c: &[DVec3]| is_flat(c, area_vector(c).unwrap());
        assert!(flat(&bent(0.0)) && flat(&bent(1e-5)));
        assert!(!flat(&bent(1e-2)));
        // a concave one, whatever its first corner
        let mut arrow = tilted(&[[0., 0.], [2., 0.], [0.2, 0.2], [0., 2.]]);
        for _ in 0..4 {
            assert!((area_vector(&arrow).unwrap().z - 0.4).abs() < 1e-12);
            assert!(flat(&arrow));
            arrow.rotate_left(1);
        }
    }

    /// In a tilted plane, so that no axis is special.
    fn tilted(flat: &[[f64; 2]]) -> Vec<DVec3> {
        flat.iter().map(|&[x, y]| DVec3::new(x, y, 5.0 + 0.5 * x - 0.25 * y)).collect()
    }

    /// The area of the triangles, as seen along z.
    fn area_along_z(triangles: &[[DVec3; 3]]) -> f64 {
        triangles.iter().map(|[a, b, c]| (*b - *a).cross(*c - *a).z.abs() / 2.0).sum()
    }

    #[test]
    fn crossing_outlines_keep_the_area_that_they_enclose() {
        for (flat, triangles, expected) in [
            // bow ties: equal halves, whose signed areas cancel; unequal ones; one on its side
            (&[[0., 0.], [1., 1.], [1., 0.], [0., 1.]][..], 2, 0.5),
            (&[[0., 0.], [2., 2.], [2., 0.], [0., 1.]], 2, 2.0 / 6.0 + 4.0 / 3.0),
            (&[[0., 0.], [1., 0.], [0., 1.], [1., 1.]], 2, 0.5),
            // an hourglass with corners on its ends, and two crossings in a row
            (&[[0., 0.], [2., 2.], [1., 3.], [0., 2.], [2., 0.], [1., -1.]], 4, 4.0),
            (&[[0., 0.], [1., 1.], [2., 0.], [2., 1.], [1., 0.], [0., 1.]], 4, 1.0),
        ] {
            for start in 0..flat.len() {
                let mut outline = tilted(flat);
                outline.rotate_left(start);
                for _ in 0..2 {
                    let Outline::Crossing(found) = Outline::of(&outline) else {
                        panic!("{outline:?}")
                    };
                    assert_eq!(found.len(), triangles, "{flat:?}");
                    assert!(
                        (area_along_z(&found) - expected).abs() < 1e-12,
                        "{flat:?}: {}",
                        area_along_z(&found)
                    );
                    outline.reverse();
                }
            }
        }
    }

    #[test]
    fn outlines_that_only_touch_themselves_are_left_alone() {
        for flat in [
            &[[0., 0.], [2., 0.], [0.2, 0.2], [0., 2.]][..],
            &[[0., 0.], [2., 0.], [2., 2.], [0., 2.]],
            // there and back; a corner on an edge
            &[[0., 0.], [1., 0.], [1., 1.], [1., 0.]],
            &[[0., 0.], [2., 0.], [1., 1.], [1., 0.]],
        ] {
            for start in 0..4 {
                let mut outline = tilted(flat);
                outline.rotate_left(start);
                assert_eq!(split_at_crossings(&outline), None, "{flat:?}");
                assert!(!matches!(Outline::of(&outline), Outline::Crossing(_)));
            }
        }
        let line = [0., 1., 0.5, 3.].map(|x| DVec3::new(x, 2.0 * x, 0.1));
        assert!(matches!(Outline::of(&line), Outline::WithoutArea));
        let nan = [DVec3::ZERO, DVec3::X, DVec3::NAN, DVec3::Y];
        assert!(matches!(Outline::of(&nan), Outline::Unusable));
    }
}
