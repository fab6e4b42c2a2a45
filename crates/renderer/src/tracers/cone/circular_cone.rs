//! The cone: a round bundle of rays about an axis.
//!
//! Paper: J. Amanatides, "Ray Tracing with Cones", SIGGRAPH 1984: an apex, an axis and a spread
//! angle. Deviations: a cone has a radius where it begins, so that those which leave a surface
//! begin as wide as their footprint; the radius may shrink, through a focus, behind which the cone
//! is upside down; it carries two directions across, in which it is cut into quarters.
//!
//! Every ray of the bundle goes through the same place of each cross-section, in units of its
//! radius. That map of space to places is a projection: lines remain lines.

use accel_core::Ray;
use accel_core::query::region::Frustum;
use glam::{DVec2, DVec3};

/// Half the distance between the centres of the quarters of a square whose area is that of the
/// unit disc: sqrt(pi) / 4.
const QUARTER: f64 = 0.443_113_462_726_379;

/// The surface that a cone leaves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DepartedSurface {
    pub id: u32,
    /// True if the cone goes into the body: against the outer geometric normal.
    pub inwards: bool,
    /// For a flat surface, or a cone into a ball, surfaces behind are not met: unit normal on the
    /// side of the cone, and the position of the surface along it.
    pub plane: Option<(DVec3, f64)>,
}

/// A cone; world units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cone {
    /// Point of the axis with depth 0.
    pub origin: DVec3,
    /// Unit direction; depths are measured along it.
    pub axis: DVec3,
    /// Unit direction across; with `up`, the axes of places.
    pub right: DVec3,
    pub up: DVec3,
    /// Radius at depth 0.
    pub radius: f64,
    /// Growth of the radius with depth: tangent of half the angle; below 0 it shrinks.
    pub spread: f64,
    /// Least depth; below 0 where the surface that the cone leaves is oblique to it.
    pub begin: f64,
    /// Largest depth, that of a light; may be infinite.
    pub end: f64,
    /// None for a cone from the eye.
    pub left: Option<DepartedSurface>,
}

impl Cone {
    /// A cone from depth 0 to infinity; `axis` is of unit length.
    pub fn new(origin: DVec3, axis: DVec3, radius: f64, spread: f64) -> Self {
        let (right, up) = axis.any_orthonormal_pair();
        let (begin, end, left) = (0.0, f64::INFINITY, None);
        Self { origin, axis, right, up, radius, spread, begin, end, left }
    }

    /// The same with directions across that are nearest to two given ones.
    pub fn across(mut self, right: DVec3, up: DVec3) -> Self {
        let flat = right - self.axis * right.dot(self.axis);
        if let Some(right) = flat.try_normalize() {
            let own = self.axis.cross(right);
            self.right = right;
            self.up = if own.dot(up) < 0.0 { -own } else { own };
        }
        self
    }

    /// The surface that it leaves, if that is the primitive `id`.
    pub fn left_surface(&self, id: u32) -> Option<DepartedSurface> {
        self.left.filter(|left| left.id == id)
    }

    /// Returns whether it is no more than a ray.
    pub fn is_ray(&self) -> bool {
        self.radius == 0.0 && self.spread == 0.0
    }

    /// Radius at a depth; below 0 behind a focus, where places are upside down.
    pub fn radius_at(&self, depth: f64) -> f64 {
        self.radius + self.spread * depth
    }

    /// A vector across: that of a place, times a radius.
    fn lateral(&self, place: DVec2) -> DVec3 {
        self.right * place.x + self.up * place.y
    }

    /// The depth of a point, where it lies across, world units, and the radius there.
    pub fn locate(&self, point: DVec3) -> (f64, DVec2, f64) {
        let way = point - self.origin;
        let depth = way.dot(self.axis);
        (depth, DVec2::new(way.dot(self.right), way.dot(self.up)), self.radius_at(depth))
    }

    /// The ray through a place; its parameter is the depth.
    pub fn ray(&self, place: DVec2) -> Ray<f64> {
        let across = self.lateral(place);
        let from = self.origin + across * self.radius;
        let mut ray = Ray::<f64>::new(from, self.axis + across * self.spread);
        (ray.t_min, ray.t_max) = (self.begin, self.end);
        ray
    }

    /// The cone about the ray through a place whose cross-section has `scale` times the radius.
    pub fn part(&self, place: DVec2, scale: f64) -> Self {
        let ray = self.ray(place);
        let length = ray.direction.length();
        let cone = Self {
            origin: ray.origin,
            axis: ray.direction / length,
            radius: self.radius * scale,
            spread: self.spread * scale / length,
            begin: self.begin * length,
            end: self.end * length,
            ..*self
        };
        cone.across(self.right, self.up)
    }

    /// Four cones in place of one: the quarters of the square that has the area of its section.
    pub fn quarters(&self) -> [Self; 4] {
        [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)]
            .map(|place| self.part(DVec2::from(place) * QUARTER, 0.5))
    }

    /// A pyramid around the cone, down to depth `end`.
    pub fn frustum(&self, end: f64) -> Frustum {
        let outline = |depth: f64| {
            let (center, radius) = (self.origin + self.axis * depth, self.radius_at(depth));
            [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
                .map(|place| center + self.lateral(DVec2::from(place)) * radius)
        };
        let mut far = outline(end);
        if self.radius_at(end) < 0.0 {
            // behind a focus: every corner to the one above it
            far.rotate_left(2);
        }
        Frustum::new(&outline(self.begin), &far)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quarters_have_a_quarter_of_the_section_each_and_hold_the_same_square() {
        let axis = DVec3::new(0.3, -0.2, -1.0).normalize();
        let cone = Cone::new(DVec3::new(1.0, 2.0, 3.0), axis, 0.01, 0.002);
        let side = cone.radius_at(5.0) * std::f64::consts::PI.sqrt();
        for quarter in cone.quarters() {
            assert!((quarter.radius_at(5.0) / cone.radius_at(5.0) - 0.5).abs() < 1e-5);
            let (depth, across, _) = cone.locate(quarter.origin + quarter.axis * 5.0);
            assert!((across.abs() - side / 4.0).length() < 1e-6 && (depth - 5.0).abs() < 1e-4);
        }
    }

    #[test]
    fn a_ray_keeps_its_place_through_a_focus() {
        let mut cone = Cone::new(DVec3::ZERO, DVec3::X, 1.0, -0.5);
        cone.begin = -1.0;
        let place = DVec2::new(0.3, -0.8);
        let ray = cone.ray(place);
        for depth in [-1.0, 0.5, 3.0, 7.0] {
            let (found, across, radius) = cone.locate(ray.at(depth));
            assert!((found - depth).abs() < 1e-12 && (across / radius - place).length() < 1e-12);
            assert!(cone.frustum(8.0).meets_balls(&[accel_core::primitives::Ball {
                center: ray.at(depth),
                radius: 0.0
            }]));
        }
    }
}
