//! Boxes as a camera sees them that is far away: in its direction, without perspective, all of the
//! scene.

use accel_core::Aabb;
use glam::{DVec2, DVec3};
use scene_loading::Camera;

/// A view without perspective.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Projection {
    right: DVec3,
    up: DVec3,
    forward: DVec3,
}

impl Projection {
    /// In the direction of the camera.
    pub fn of(camera: &Camera) -> Self {
        let forward = (camera.at - camera.from).normalize_or(DVec3::NEG_Z);
        let side = forward.cross(camera.up);
        let right = side.try_normalize().unwrap_or_else(|| forward.any_orthonormal_vector());
        Self { right, up: right.cross(forward), forward }
    }

    /// Image position of a point: right, up.
    pub fn coordinates(&self, p: DVec3) -> [f64; 2] {
        [p.dot(self.right), p.dot(self.up)]
    }

    /// How far away it is.
    pub fn depth(&self, p: DVec3) -> f64 {
        p.dot(self.forward)
    }

    /// Left, lower, right and upper ends of a box.
    pub fn ends(&self, b: &Aabb<f64>) -> [f64; 4] {
        let corners = (0..8).map(|i| DVec2::from(self.coordinates(corner(b, i))));
        let start = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        let (low, high) = corners.fold(start, |(low, high), p| (low.min(p), high.max(p)));
        [low.x, low.y, high.x, high.y]
    }

    /// The faces of a box that are turned to the viewer, by axis; each with its corners.
    pub fn faces(&self, b: &Aabb<f64>) -> Vec<(usize, [[f64; 2]; 4])> {
        let face = |k: usize| {
            // across the view, a face is a line
            if self.forward[k].abs() < 1e-9 {
                return None;
            }
            let near = usize::from(self.forward[k] < 0.0) << k;
            let (i, j) = (1 << ((k + 1) % 3), 1 << ((k + 2) % 3));
            let around = [near, near | i, near | i | j, near | j];
            Some((k, around.map(|c| self.coordinates(corner(b, c)))))
        };
        (0..3).filter_map(face).collect()
    }
}

/// A corner of a box: on the upper side of axis k where bit k is set.
fn corner(b: &Aabb<f64>, bits: usize) -> DVec3 {
    let side = |k: usize| if bits >> k & 1 == 1 { b.max[k] } else { b.min[k] };
    DVec3::new(side(0), side(1), side(2))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn three_faces_are_seen_and_they_fill_the_outline() {
        let from = DVec3::new(3.0, -5.0, 2.0);
        let camera = Camera { from, at: DVec3::ZERO, up: DVec3::Z, ..Camera::default() };
        let view = Projection::of(&camera);
        let b = Aabb { min: DVec3::splat(-1.0), max: DVec3::ONE };
        let faces = view.faces(&b);
        assert_eq!(faces.len(), 3);
        // all three meet in the corner that is nearest
        let nearest = view.coordinates(DVec3::new(1.0, -1.0, 1.0));
        assert!(faces.iter().all(|(_, corners)| corners.contains(&nearest)));
        let [left, low, right, high] = view.ends(&b);
        let all = || faces.iter().flat_map(|(_, corners)| corners);
        assert!(all().all(|p| left <= p[0] && p[0] <= right && low <= p[1] && p[1] <= high));
        assert!(all().any(|p| p[0] == left) && all().any(|p| p[1] == high));
    }
}
