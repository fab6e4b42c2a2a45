//! From where cells are seen: cut by a plane, or as boxes by a camera that is far away.

use accel_core::{Aabb, Ray};
use glam::{DVec2, DVec3};
use scene_loading::{Camera, Scene};

/// A plane with coordinates: along a horizontal direction, and along an axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plane {
    /// A point of it, where the first coordinate is 0.
    origin: DVec3,
    /// A unit vector without a part along the axis.
    across: DVec3,
    /// The axis of the second coordinate.
    up: usize,
}

/// Axes by their letters.
pub const LETTERS: [char; 3] = ['x', 'y', 'z'];

impl Plane {
    /// Plane at a coordinate of an axis; the camera decides the directions right and up.
    pub fn at(axis: usize, position: f64, camera: &Camera) -> Self {
        let forward = camera.at - camera.from;
        let mut up = up_axis(camera);
        if up == axis {
            // seen from above: what is farther away is higher
            let mut others = forward;
            others[axis] = 0.0;
            up = match largest(others) {
                k if k == axis => (axis + 1) % 3,
                k => k,
            };
        }
        let side = 3 - axis - up;
        let right = forward.cross(camera.up);
        let mut across = DVec3::ZERO;
        across[side] = if right[side] < 0.0 { -1.0 } else { 1.0 };
        let mut origin = DVec3::ZERO;
        origin[axis] = position;
        Self { origin, across, up }
    }

    /// The axis that a view's direction is nearest to, but not what is up: what slices are across
    /// unless another one is asked for.
    pub fn usual_axis(camera: &Camera) -> usize {
        let mut forward = camera.at - camera.from;
        forward[up_axis(camera)] = 0.0;
        match largest(forward) {
            k if k == up_axis(camera) => (k + 1) % 3,
            k => k,
        }
    }

    /// The plane through a ray that is upright, or nearly: it holds the axis that is up unless the
    /// ray is along that.
    pub fn through(ray: &Ray<f64>, camera: &Camera) -> Self {
        let direction = ray.direction.normalize_or(DVec3::X);
        let mut up = up_axis(camera);
        let level = |up: usize| {
            let mut level = direction;
            level[up] = 0.0;
            level
        };
        if level(up).length() < 0.1 {
            up = (up + 1) % 3;
        }
        let mut across = level(up).normalize_or(DVec3::X);
        // to the right where the camera sees it run there
        if across.dot((camera.at - camera.from).cross(camera.up)) < 0.0 {
            across = -across;
        }
        let mut origin = ray.origin;
        origin -= across * origin.dot(across);
        origin[up] = 0.0;
        Self { origin, across, up }
    }

    /// The coordinates of a point of it, or of the nearest one.
    pub fn coordinates(&self, p: DVec3) -> [f64; 2] {
        [(p - self.origin).dot(self.across), p[self.up]]
    }

    /// How far a point is from it, with a sign.
    pub fn distance(&self, p: DVec3) -> f64 {
        let mut axis = DVec3::ZERO;
        axis[self.up] = 1.0;
        (p - self.origin).dot(self.across.cross(axis))
    }

    /// Section of a box: left, lower, right and upper coordinates. Of two boxes that touch in the
    /// plane, one is cut.
    pub fn cut(&self, b: &Aabb<f64>) -> Option<[f64; 4]> {
        let (mut from, mut to) = (f64::NEG_INFINITY, f64::INFINITY);
        for k in (0..3).filter(|k| *k != self.up) {
            let (lo, hi) = (b.min[k] - self.origin[k], b.max[k] - self.origin[k]);
            if self.across[k] == 0.0 {
                if !(lo <= 0.0 && 0.0 < hi) {
                    return None;
                }
                continue;
            }
            let ends = [lo / self.across[k], hi / self.across[k]];
            from = from.max(ends[0].min(ends[1]));
            to = to.min(ends[0].max(ends[1]));
        }
        (from < to).then_some([from, b.min[self.up], to, b.max[self.up]])
    }

    /// Description: `z = 1.5`, or upright through a ray, in coordinates of the file. `origin` is
    /// the scene's origin in them.
    pub fn name(&self, origin: DVec3) -> String {
        let on_axis = (0..3).find(|&k| k != self.up && self.across[k] == 0.0);
        match on_axis {
            Some(k) if origin[k] != 0.0 => {
                format!("{} = {}", LETTERS[k], self.origin[k] + origin[k])
            }
            Some(k) => format!("{} = {}", LETTERS[k], presentation::numbers::short(self.origin[k])),
            None => format!("the plane through the ray and along {}", LETTERS[self.up]),
        }
    }
}

/// Up axis in pictures of a scene: the one nearest to the camera's.
pub fn up_axis(camera: &Camera) -> usize {
    largest(camera.up)
}

/// The axis nearest to a direction.
fn largest(direction: DVec3) -> usize {
    let size = direction.abs().to_array();
    (0..3).fold(0, |best, k| if size[k] > size[best] { k } else { best })
}

/// The box of all that a scene shows.
pub fn scene_box(scene: &Scene) -> Aabb<f64> {
    let bounds = scene.bounds();
    Aabb { min: bounds.min, max: bounds.max }
}

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

    fn camera(from: DVec3, up: DVec3) -> Camera {
        Camera { from, at: DVec3::ZERO, up, ..Camera::default() }
    }

    #[test]
    fn slices_are_seen_from_the_camera() {
        // from the front, z up: x is to the right
        let front = camera(DVec3::new(0.5, -9.0, 1.0), DVec3::Z);
        assert_eq!((Plane::usual_axis(&front), up_axis(&front)), (1, 2));
        let plane = Plane::at(1, 2.0, &front);
        let unit = Aabb { min: DVec3::ZERO, max: DVec3::new(4.0, 3.0, 2.0) };
        assert_eq!(plane.cut(&unit), Some([0.0, 0.0, 4.0, 2.0]));
        assert_eq!(plane.name(DVec3::ZERO), "y = 2.00");
        assert_eq!(plane.name(DVec3::splat(5.4e6)), "y = 5400002");
        assert_eq!(plane.coordinates(DVec3::new(3.0, 2.0, 1.0)), [3.0, 1.0]);
        // boxes that touch in the plane: one of them
        assert_eq!(Plane::at(1, 3.0, &front).cut(&unit), None);
        assert!(Plane::at(1, 0.0, &front).cut(&unit).is_some());
        // from behind, x is to the left
        let behind = camera(DVec3::new(0.5, 9.0, 1.0), DVec3::Z);
        assert_eq!(Plane::at(1, 2.0, &behind).cut(&unit), Some([-4.0, 0.0, 0.0, 2.0]));
        // from above, what is far is high
        assert_eq!(Plane::at(2, 1.0, &front).cut(&unit), Some([0.0, 0.0, 4.0, 3.0]));
    }

    #[test]
    fn the_plane_of_a_ray_holds_it() {
        let front = camera(DVec3::new(0.5, -9.0, 1.0), DVec3::Z);
        for direction in [DVec3::new(1.0, 2.0, 0.5), DVec3::new(0.0, 0.0, -1.0), DVec3::NEG_X] {
            let ray = Ray::<f64>::new(DVec3::new(0.1, 0.7, 0.2), direction);
            let plane = Plane::through(&ray, &front);
            for t in [0.0, 1.0, 7.5] {
                assert!(plane.distance(ray.at(t)).abs() < 1e-12, "{direction}");
            }
            // a box around a point of the ray is cut, and its section holds the point
            let p = ray.at(2.0);
            let around = Aabb { min: p - 0.5, max: p + 0.5 };
            let [x, y] = plane.coordinates(p);
            let [left, low, right, high] = plane.cut(&around).unwrap();
            assert!(left < x && x < right && low < y && y < high);
        }
    }

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
