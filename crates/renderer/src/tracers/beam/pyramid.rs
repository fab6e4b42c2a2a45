//! A beam's pyramid: an apex, and a direction for every point of the image.
//!
//! Paper: P. Heckbert, P. Hanrahan, "Beam Tracing Polygonal Objects", SIGGRAPH 1984, section 3
//! (the beam transformation). Deviation: a beam stays in the coordinates (u, v) of the image, in
//! pixels from the corner of a tile, through all mirrors; only its apex and its three vectors are
//! transformed. A point of the beam is `apex + s (D + u U + v V)`; `s` grows along every ray, and
//! on a plane 1/s is affine in (u, v), so that depths are compared exactly.

use accel_core::query::region::Frustum;
use glam::{DMat3, DVec2, DVec3};

use super::convex::{Affine, ConvexPolygon, edges};

/// Surfaces nearer than this to the surface a beam leaves, or to its apex, are not met: in units of
/// the scene's largest coordinate.
const OFFSET: f64 = 1e-12;

/// The part of space with `normal . x >= least`.
#[derive(Debug, Clone, Copy, PartialEq)]
struct HalfSpace {
    normal: DVec3,
    least: f64,
}

/// A plane that a beam meets: unit normal, and a point of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plane {
    /// Unit normal, either side.
    pub normal: DVec3,
    pub point: DVec3,
    /// 1/s on it, for the beam that meets it.
    pub depth: Affine,
}

#[derive(Debug, Clone)]
pub struct Pyramid {
    apex: DVec3,
    /// Columns U, V and D.
    frame: DMat3,
    inverse: DMat3,
    keeps: Vec<HalfSpace>,
    /// 1/s on the surface it comes from, if it comes from one.
    from: Option<Affine>,
    /// The scene's largest coordinate, world units.
    magnitude: f64,
}

impl Pyramid {
    /// From an eye: `frame` has the columns U, V and D. `magnitude` is the scene's largest
    /// coordinate, the eye's included. `None` when the three vectors lie in a plane.
    pub fn new(apex: DVec3, frame: DMat3, magnitude: f64) -> Option<Self> {
        let inverse = frame.inverse();
        // s of a point is linear in it
        let ahead = inverse.row(2).try_normalize()?;
        let keeps = vec![HalfSpace { normal: ahead, least: ahead.dot(apex) + OFFSET * magnitude }];
        let all = [inverse.x_axis, inverse.y_axis, inverse.z_axis];
        let this = Self { apex, frame, inverse, keeps, from: None, magnitude };
        all.iter().all(|column| column.is_finite()).then_some(this)
    }

    /// The direction through an image point, of any length.
    pub fn direction(&self, p: DVec2) -> DVec3 {
        self.frame * p.extend(1.0)
    }

    /// The point behind an image point where 1/s is `depth`.
    pub fn point(&self, p: DVec2, depth: f64) -> DVec3 {
        self.apex + self.direction(p) / depth
    }

    /// The point (s u, s v, s) of a world point.
    pub fn project(&self, x: DVec3) -> DVec3 {
        self.inverse * (x - self.apex)
    }

    /// The pyramid behind a plane, under a linear map that leaves the plane as it is: a point at
    /// the height h over the plane is moved by `shear` times h. Minus twice the normal is a mirror,
    /// exactly; for glass see `bend.rs`. What follows lies on the side of `towards`.
    pub fn through(&self, plane: &Plane, shear: DVec3, towards: DVec3) -> Option<Self> {
        let Plane { normal, point, depth } = *plane;
        let mapped = |v: DVec3| v + shear * normal.dot(v);
        let [u, v, d] = [self.frame.x_axis, self.frame.y_axis, self.frame.z_axis].map(mapped);
        let apex = point + mapped(self.apex - point);
        let mut this = Self::new(apex, DMat3::from_cols(u, v, d), self.magnitude)?;
        this.leave(point, if normal.dot(towards) < 0.0 { -normal } else { normal });
        this.from = Some(depth);
        Some(this)
    }

    /// The pyramid from a light onto a plane that this one meets, so that both meet the plane at
    /// equal (u, v): the shadow beam. It holds what lies between light and plane. `None` for a
    /// light in the plane.
    pub fn shadow(&self, plane: &Plane, light: DVec3) -> Option<Self> {
        let height = plane.normal.dot(light - plane.point);
        let normal = if height < 0.0 { -plane.normal } else { plane.normal };
        if height.abs() <= 2.0 * OFFSET * self.magnitude {
            return None;
        }
        // (apex + d / q) - light = ((apex - light) q + d) / q, where q, 1/s, is affine
        let (away, q) = (self.apex - light, plane.depth);
        let frame = DMat3::from_cols(
            self.frame.x_axis + away * q.slope.x,
            self.frame.y_axis + away * q.slope.y,
            self.frame.z_axis + away * q.offset,
        );
        let mut this = Self::new(light, frame, self.magnitude)?;
        this.leave(plane.point, normal);
        let most = normal.dot(light) - OFFSET * self.magnitude;
        this.keeps.push(HalfSpace { normal: -normal, least: -most });
        Some(this)
    }

    fn leave(&mut self, point: DVec3, normal: DVec3) {
        let least = normal.dot(point) + OFFSET * self.magnitude;
        self.keeps.push(HalfSpace { normal, least });
    }

    /// True when all of an outline lies on the far side of one side of the pyramid behind the
    /// rectangle from `low` to `high`, or behind the apex.
    pub fn is_beside(&self, outline: &[DVec3], low: DVec2, high: DVec2) -> bool {
        let mut beside = [true; 5];
        for &x in outline {
            let DVec3 { x, y, z: s } = self.project(x);
            let now = [x < low.x * s, x > high.x * s, y < low.y * s, y > high.y * s, s < 0.0];
            beside.iter_mut().zip(now).for_each(|(all, now)| *all &= now);
        }
        beside.contains(&true)
    }

    /// The part of a convex outline that the pyramid can meet.
    pub fn keep(&self, outline: &[DVec3]) -> Vec<DVec3> {
        self.keeps.iter().fold(outline.to_vec(), |corners, half| half.clip(corners))
    }

    /// The part of space behind a piece of the image, `reach` long, world units.
    pub fn frustum(&self, piece: &ConvexPolygon, reach: f64) -> Frustum {
        let unit = |p: &DVec2| self.direction(*p).normalize_or_zero();
        let directions: Vec<DVec3> = piece.corners().iter().map(unit).collect();
        let middle = self.direction(piece.centroid()).normalize_or_zero();
        // oblique edges must reach as far as the middle
        let least = directions.iter().map(|d| d.dot(middle)).fold(1.0, f64::min).max(1e-3);
        let near: Vec<DVec3> = piece.corners().iter().map(|p| self.start(*p)).collect();
        let far: Vec<DVec3> =
            near.iter().zip(&directions).map(|(p, d)| *p + *d * (reach / least)).collect();
        Frustum::new(&near, &far)
    }

    /// Origin of the ray through an image point.
    fn start(&self, p: DVec2) -> DVec3 {
        self.from.map_or(self.apex, |depth| self.point(p, depth.at(p)))
    }

    /// The part of space between a piece of a plane that this pyramid meets, and a light.
    pub fn frustum_to(&self, piece: &ConvexPolygon, plane: &Plane, light: DVec3) -> Frustum {
        let near: Vec<DVec3> =
            piece.corners().iter().map(|p| self.point(*p, plane.depth.at(*p))).collect();
        Frustum::new(&near, &vec![light; near.len()])
    }
}

impl HalfSpace {
    fn clip(&self, corners: Vec<DVec3>) -> Vec<DVec3> {
        let height = |p: DVec3| self.normal.dot(p) - self.least;
        if corners.iter().all(|&p| height(p) >= 0.0) {
            return corners;
        }
        let mut kept = Vec::with_capacity(corners.len() + 1);
        for (a, b) in edges(&corners) {
            let (ha, hb) = (height(a), height(b));
            if ha >= 0.0 {
                kept.push(a);
            }
            if (ha > 0.0 && hb < 0.0) || (ha < 0.0 && hb > 0.0) {
                kept.push(a + (b - a) * (ha / (ha - hb)));
            }
        }
        kept
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::reflect;

    fn pyramid() -> Pyramid {
        let frame = DMat3::from_cols(
            DVec3::new(0.1, 0.0, 0.01),
            DVec3::new(0.0, -0.1, 0.02),
            DVec3::new(-0.4, 0.3, -1.0),
        );
        Pyramid::new(DVec3::new(1.0, 2.0, 3.0), frame, 10.0).unwrap()
    }

    fn plane(pyramid: &Pyramid, normal: DVec3, point: DVec3) -> Plane {
        let normal = normal.normalize();
        // 1/s on it
        let over = normal.dot(point - pyramid.apex);
        let along = pyramid.frame.transpose() * normal / over;
        let depth = Affine { slope: along.truncate(), offset: along.z };
        Plane { normal, point, depth }
    }

    const PLACES: [DVec2; 3] = [DVec2::ZERO, DVec2::new(3.0, 1.0), DVec2::new(7.9, 6.5)];

    #[test]
    fn points_project_to_where_they_came_from() {
        let pyramid = pyramid();
        for p in PLACES {
            let at = pyramid.project(pyramid.point(p, 0.25));
            assert!((at - p.extend(1.0) * 4.0).length() < 1e-12, "{at}");
        }
    }

    #[test]
    fn mirrors_are_exact() {
        let pyramid = pyramid();
        let plane = plane(&pyramid, DVec3::new(0.2, 0.1, 1.0), DVec3::new(0.0, 0.0, -4.0));
        for p in PLACES {
            let d = pyramid.direction(p).normalize();
            let at = pyramid.point(p, plane.depth.at(p));
            assert!((at - plane.point).dot(plane.normal).abs() < 1e-12);
            let expected = reflect(d, plane.normal);
            let mirrored = pyramid.through(&plane, plane.normal * -2.0, expected).unwrap();
            assert!((mirrored.direction(p).normalize() - expected).length() < 1e-14);
            assert!((mirrored.start(p) - at).length() < 1e-12);
        }
    }

    #[test]
    fn shadow_beams_meet_the_plane_at_the_same_places() {
        let pyramid = pyramid();
        let plane = plane(&pyramid, DVec3::new(0.2, 0.1, 1.0), DVec3::new(0.0, 0.0, -4.0));
        let light = DVec3::new(-3.0, 5.0, 2.0);
        let shadow = pyramid.shadow(&plane, light).unwrap();
        for p in PLACES {
            let at = pyramid.point(p, plane.depth.at(p));
            for share in [0.1, 0.5, 0.9] {
                let between = shadow.project(light + (at - light) * share);
                assert!((between.truncate() / between.z - p).length() < 1e-12);
            }
        }
        assert!(pyramid.shadow(&plane, plane.point).is_none());
    }

    #[test]
    fn polygons_behind_the_eye_are_clipped() {
        let pyramid = pyramid();
        let plane = plane(&pyramid, DVec3::Z, DVec3::ZERO);
        let towards = |z: f64| pyramid.through(&plane, plane.normal * -2.0, DVec3::Z * z).unwrap();
        let across = [DVec3::new(0.0, 0.0, -1.0), DVec3::new(1.0, 0.0, -1.0), DVec3::Z * 2.0];
        assert_eq!(towards(1.0).keep(&across).len(), 3);
        let kept = towards(1.0).keep(&across);
        assert!(kept.iter().all(|p| p.z > 0.0 && p.z < 2.1), "{kept:?}");
        // what lies in the mirror's plane is not met
        assert!(towards(1.0).keep(&[DVec3::ZERO, DVec3::X, DVec3::Y]).is_empty());
        // planted fault: the mirror's plane forgotten, so that what is behind it comes through
        let mut open = towards(1.0);
        assert!(open.keep(&across.map(|p| p - DVec3::Z * 3.0)).is_empty());
        open.keeps.truncate(1);
        assert!(!open.keep(&across.map(|p| p - DVec3::Z * 3.0 + DVec3::Z)).is_empty());
        // behind the eye
        let behind = across.map(|p| p + DVec3::Z * 5.0);
        assert!(pyramid.keep(&behind).is_empty());
    }
}
