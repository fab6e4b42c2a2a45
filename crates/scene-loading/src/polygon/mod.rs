//! Planar polygons: normal, flatness, and triangles.

#[allow(clippy::indexing_slicing)]
mod crossing;
#[allow(clippy::indexing_slicing)]
pub(crate) mod ear_clipping;
mod plane;
#[allow(clippy::indexing_slicing)]
mod point_tree;

use glam::DVec3;

pub(crate) use plane::{area_vector, is_flat};

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
        let crossing = || crossing::split_at_crossings(corners).filter(|all| !all.is_empty());
        match area_vector(corners) {
            Some(_) if corners.len() == 3 => Self::Flat,
            Some(area) if !is_flat(corners, area) => Self::Bent(area),
            Some(_) if !crossing::may_cross(corners) => Self::Flat,
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

#[cfg(test)]
mod tests {
    use super::ear_clipping::triangulate;
    use super::*;

    fn area_of(corners: &[DVec3], triangles: &[[u32; 3]]) -> f64 {
        let twice = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|i| corners[i as usize]);
            (b - a).cross(c - a).length()
        };
        triangles.iter().map(twice).sum::<f64>() / 2.0
    }

    #[test]
    fn a_concave_quadrangle_keeps_its_area() {
        // Any rotation of the corners; a fan from some of them covers 3.6 instead of 0.4.
        let ring = [(0.0, 0.0), (2.0, 0.0), (0.2, 0.2), (0.0, 2.0)];
        for start in 0..4 {
            let corners: Vec<DVec3> = (0..4)
                .map(|i| ring[(start + i) % 4])
                .map(|(x, y)| DVec3::new(x, y, 3.0 + 0.5 * x))
                .collect();
            let area = area_vector(&corners).unwrap();
            assert!((area.z - 0.4).abs() < 1e-12);
            assert!(is_flat(&corners, area));
            let triangles = triangulate(&corners).unwrap();
            assert_eq!(triangles.len(), 2);
            assert!((area_of(&corners, &triangles) - area.length()).abs() < 1e-12);
            for [a, b, c] in triangles.iter().map(|t| t.map(|i| corners[i as usize])) {
                assert!((b - a).cross(c - a).dot(area) > 0.0);
            }
        }
    }

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
    }
}
