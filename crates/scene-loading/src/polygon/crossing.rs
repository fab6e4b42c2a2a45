//! Flat outlines that cross themselves: cut at the crossings into loops that do not.

use glam::{DVec2, DVec3};

use super::ear_clipping::triangulate;
use super::plane::{ZERO_AREA, area_vector, is_flat, orientation};

/// Outlines of more corners are not looked at: every edge is compared with every other.
const MAX_CORNERS: usize = 16;

/// True for a quadrangle that is concave at its first or third corner, or crosses itself: those two
/// lie on one side of the line through the others.
pub(super) fn may_cross(corners: &[DVec3]) -> bool {
    let &[a, b, c, d] = corners else { return false };
    (b - a).cross(c - a).dot((c - a).cross(d - a)) < 0.0
}

/// The triangles of a flat outline that crosses itself; crossings become corners. None where it
/// does not, or has more than 16 corners.
pub(super) fn split_at_crossings(corners: &[DVec3]) -> Option<Vec<[DVec3; 3]>> {
    if !(4..=MAX_CORNERS).contains(&corners.len()) {
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
        match first_crossing(&outline, flat).filter(|_| cuts < 2 * MAX_CORNERS) {
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
    use super::super::Outline;
    use super::*;

    /// In a tilted plane, so that no axis is special.
    fn tilted(flat: &[[f64; 2]]) -> Vec<DVec3> {
        flat.iter().map(|&[x, y]| DVec3::new(x, y, 5.0 + 0.5 * x - 0.25 * y)).collect()
    }

    /// The area of the triangles, as seen along z.
    fn area(triangles: &[[DVec3; 3]]) -> f64 {
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
                    assert!((area(&found) - expected).abs() < 1e-12, "{flat:?}: {}", area(&found));
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
