//! Share of a cone covered by a sphere.
//!
//! Paper: J. Amanatides, "Ray Tracing with Cones", SIGGRAPH 1984: the overlap of two discs.
//! Deviation: the disc of the sphere is taken where its silhouette comes nearest to the axis, so
//! that large spheres keep their exact edges. Seen from the apex at the angle g from the axis, a
//! sphere of angular radius b has its nearest silhouette point at tan(g - b) on the cross-section
//! at unit distance. The silhouette is a conic there, and its radius of curvature in that point is
//! tan(b): with the cone of tangents (x sin g + cos g)^2 = cos^2 b (x^2 + y^2 + 1), half the
//! derivative of y^2 by x at y = 0 is sin g / (cos b cos(g - b)) - tan(g - b) = tan b. The disc is
//! the one that touches the conic there.

use accel_core::Ray;
use accel_core::primitives::Sphere;
use glam::DVec2;

use super::circular_cone::Cone;
use super::coverage::{Coverage, Outline};
use super::disc_overlap::{Overlap, of_disc};

/// A cone whose radius changes by less than this part over the way to the sphere is a cylinder.
const PARALLEL: f64 = 1e-7;

pub struct Ball {
    pub id: u32,
    pub sphere: Sphere<f64>,
}

impl Ball {
    pub fn new(id: u32, sphere: &scene_loading::Sphere) -> Self {
        Self { id, sphere: Sphere { center: sphere.center, radius: sphere.radius.abs() } }
    }

    pub fn cover(&self, cone: &Cone) -> Option<Coverage> {
        let own = cone.left_surface(self.id);
        let plane = cone.left.and_then(|left| left.plane);
        let (center, size) = (self.sphere.center, self.sphere.radius);
        let (depth, across, radius) = cone.locate(center);
        if size <= 0.0 || depth + size < cone.begin || depth - size > cone.end {
            return None;
        }
        let is_inside = match own {
            Some(left) if !left.inwards => return None,
            Some(_) => true,
            None => center.distance_squared(cone.origin) < size * size,
        };
        let mut doubtful = false;
        if let Some((normal, at)) = plane {
            let height = normal.dot(center) - at;
            if height <= -size {
                return None;
            }
            doubtful = own.is_none() && height < size;
        }
        let (overlap, disc) = if is_inside {
            (Overlap::ALL, (DVec2::ZERO, f64::INFINITY))
        } else {
            let disc = silhouette(cone, depth, across, radius, size)?;
            (of_disc(disc.0, disc.1), disc)
        };
        if overlap.share == 0.0 {
            return None;
        }
        let ray = cone.ray(overlap.centroid);
        match self.depth(cone, overlap.centroid) {
            Some(depth) => {
                let plane = plane.filter(|_| own.is_none());
                if plane.is_some_and(|(normal, at)| normal.dot(ray.at(depth)) < at) {
                    return None;
                }
            }
            // the disc is a little larger than the silhouette, or the sphere is not in front
            None if overlap.share >= 1.0 || self.nearest(&ray) < cone.begin => return None,
            None if self.sphere.intersect(&ray, f64::INFINITY).is_some() => return None,
            None => {}
        }
        // the silhouette is nearer than the centre, the far side never farther than this
        let far = if is_inside { depth + size } else { depth };
        let outline = Outline::Disc { center: disc.0, radius: disc.1 };
        Some(Coverage { overlap, outline, far, doubtful })
    }

    /// The depth at which the ray through a place meets it: from within the far side, else the near
    /// one alone.
    pub fn depth(&self, cone: &Cone, place: DVec2) -> Option<f64> {
        let own = cone.left_surface(self.id);
        let mut ray = cone.ray(place);
        let (center, size) = (self.sphere.center, self.sphere.radius);
        let is_inside = own.is_some_and(|left| left.inwards)
            || own.is_none() && center.distance_squared(cone.origin) < size * size;
        // the two sides are before and after the middle of the chord
        let middle = self.nearest(&ray);
        if is_inside {
            ray.t_min = middle.max(ray.t_min);
        } else {
            ray.t_max = middle.min(ray.t_max);
        }
        self.sphere.intersect(&ray, ray.t_max)
    }

    /// The depth at which a ray comes nearest to the centre.
    fn nearest(&self, ray: &Ray<f64>) -> f64 {
        (self.sphere.center - ray.origin).dot(ray.direction) / ray.direction.dot(ray.direction)
    }
}

/// Centre and radius of the disc in place of the silhouette; `None` when it is not in front.
fn silhouette(
    cone: &Cone,
    depth: f64,
    across: DVec2,
    radius: f64,
    size: f64,
) -> Option<(DVec2, f64)> {
    let lateral = across.length();
    let outwards = across / lateral;
    let outwards = if outwards.is_finite() { outwards } else { DVec2::X };
    let way = depth.abs() + size;
    if cone.spread.abs() * way < PARALLEL * cone.radius {
        return Some((outwards * (lateral / cone.radius), size / cone.radius));
    }
    // from the apex; behind it, the sphere still may reach forwards
    let ahead = if cone.spread > 0.0 { radius / cone.spread } else { (radius / cone.spread).abs() };
    let distance = lateral.hypot(ahead);
    if distance <= size {
        return Some((DVec2::ZERO, f64::INFINITY));
    }
    let half = (size / distance).asin();
    let nearest = lateral.atan2(ahead) - half;
    if nearest >= std::f64::consts::FRAC_PI_2 {
        return None;
    }
    let spread = cone.spread.abs();
    let curvature_radius = half.tan() / spread;
    let center = nearest.tan() / spread + curvature_radius;
    // upside down behind a focus
    let center = if cone.spread < 0.0 && radius < 0.0 { -center } else { center };
    Some((outwards * center, curvature_radius))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tracers::cone::circular_cone::DepartedSurface;
    use crate::tracers::cone::disc_overlap::tests::counted;
    use glam::DVec3;

    #[test]
    fn sphere_coverage_equals_the_share_of_rays() {
        let ball = |x: f64, y: f64, z: f64, radius: f64| Ball {
            id: 0,
            sphere: Sphere { center: DVec3::new(x, y, z), radius },
        };
        let eye = Cone::new(DVec3::ZERO, DVec3::Z, 0.0, 0.01);
        let beam = Cone::new(DVec3::ZERO, DVec3::Z, 0.05, 0.0);
        let footprint = Cone::new(DVec3::ZERO, DVec3::Z, 0.05, 0.02);
        let lens = Cone::new(DVec3::ZERO, DVec3::Z, 0.1, -0.02);
        // large and oblique: the edge is exact to 1e-3 of the share
        let cases = [
            (eye, ball(3.0, 0.0, 5.0, 2.98)),
            (eye, ball(3.0, 1.0, 5.0, 3.17)),
            (eye, ball(1.0, 0.0, 100.0, 0.6)),
            (eye, ball(0.2, 0.1, 100.0, 0.4)),
            (beam, ball(1.0, 0.0, 50.0, 1.02)),
            (footprint, ball(1.0, 0.0, 3.0, 0.95)),
            (lens, ball(0.02, 0.03, 4.0, 0.03)),
            (lens, ball(0.04, 0.02, 8.0, 0.03)),
            (lens, ball(1.0, 0.0, 9.0, 1.03)),
        ];
        for (cone, ball) in cases {
            let share = ball.cover(&cone).map_or(0.0, |c| c.overlap.share);
            let (expected, _) = counted(200, |place| ball.depth(&cone, place).is_some());
            assert!(expected > 0.02 && expected < 0.99, "{expected}");
            let off = (share - expected).abs();
            assert!(off < 0.01, "{share} {expected} {:?} {cone:?}", ball.sphere);
        }
    }

    #[test]
    fn spheres_around_and_behind_the_origin() {
        let ball = Ball { id: 0, sphere: Sphere { center: DVec3::Z, radius: 2.0 } };
        let cone = Cone::new(DVec3::ZERO, DVec3::Z, 0.0, 0.01);
        assert_eq!(ball.cover(&cone).unwrap().overlap, Overlap::ALL);
        assert_eq!(ball.depth(&cone, DVec2::ZERO), Some(3.0));
        let away = Cone::new(DVec3::Z * 4.0, DVec3::Z, 0.0, 0.01);
        assert_eq!(ball.cover(&away), None);
        let leaving = |inwards| {
            let cone = Cone::new(DVec3::Z * -1.0, DVec3::Z, 0.1, 0.01);
            Cone { left: Some(DepartedSurface { id: 0, inwards, plane: None }), ..cone }
        };
        assert_eq!(ball.cover(&leaving(false)), None);
        assert_eq!(ball.cover(&leaving(true)).unwrap().overlap, Overlap::ALL);
        assert_eq!(ball.depth(&leaving(true), DVec2::ZERO), Some(4.0));
    }
}
