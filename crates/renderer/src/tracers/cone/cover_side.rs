//! Share of a cone (a bundle of rays) covered by the side of a truncated cone or cylinder.
//!
//! Paper: J. Amanatides, "Ray Tracing with Cones", SIGGRAPH 1984, has no such surface. Ours: a side
//! without caps shows its outside alone, so that what is seen of it, from the apex of the bundle,
//! are those lines from rim to rim whose normal faces the apex. At the angle a around the axis the
//! normal faces it where A cos(a - a0) > B: A and a0 are distance and direction of the apex from
//! the axis, B is the radius of the side at the apex's height. So the visible part lies between
//! two known lines and two arcs of the rims, and covers what that outline covers: the body is
//! convex, and no visible part hides another. The lines are exact, the arcs are chords.

use accel_core::primitives::Cone as Body;
use glam::{DVec2, DVec3};

use super::circular_cone::Cone;
use super::cover_flat::project;
use super::coverage::{Coverage, Outline};

/// How far an arc may bulge over its chord, in radii of the bundle.
const BULGE: f64 = 0.01;

pub struct Side {
    id: u32,
    body: Body<f64>,
    base: DVec3,
    apex: DVec3,
    /// From base to apex.
    axis: DVec3,
    right: DVec3,
    up: DVec3,
    radii: [f64; 2],
    /// Change of the radius along the axis.
    slope: f64,
    shows_inside: bool,
}

impl Side {
    pub fn new(id: u32, cone: &scene_loading::Cone) -> Self {
        let way = cone.apex - cone.base;
        let length = way.length();
        let axis = way.try_normalize().unwrap_or(DVec3::Z);
        let (right, up) = axis.any_orthonormal_pair();
        let radii = [cone.base_radius.abs(), cone.apex_radius.abs()];
        Self {
            id,
            body: Body::new(cone.base, cone.base_radius, cone.apex, cone.apex_radius),
            base: cone.base,
            apex: cone.apex,
            axis,
            right,
            up,
            radii,
            slope: if length > 0.0 { (radii[1] - radii[0]) / length } else { 0.0 },
            shows_inside: cone.base_radius + cone.apex_radius < 0.0,
        }
    }

    pub fn middle(&self) -> DVec3 {
        (self.base + self.apex) * 0.5
    }

    pub fn cover(&self, cone: &Cone) -> Option<Coverage> {
        let is_own = cone.left_surface(self.id).is_some();
        if (is_own && !self.shows_inside) || self.base == self.apex {
            return None;
        }
        let (from, to) = self.visible(cone)?;
        let rim = |end: usize, angle: f64| {
            let (sin, cos) = angle.sin_cos();
            let center = if end == 0 { self.base } else { self.apex };
            center + (self.right * cos + self.up * sin) * self.radii[end]
        };
        // where the bundle is narrowest, arcs are longest
        let nearest = [self.base, self.apex].map(|p| cone.locate(p).2.abs());
        let size = self.radii[0].max(self.radii[1]) / nearest[0].min(nearest[1]).max(1e-9);
        let pieces = ((to - from) * (size / (8.0 * BULGE)).sqrt()).ceil().clamp(4.0, 64.0);
        let angle = |k: u32| from + (to - from) * (f64::from(k) / pieces);
        let ends = 0..=pieces as u32;
        let corners: Vec<DVec3> = (ends.clone().map(|k| rim(0, angle(k))))
            .chain(ends.rev().map(|k| rim(1, angle(k))))
            .collect();
        let (overlap, outline, _) = project(cone, &corners)?;
        let across = (1.0 - self.axis.dot(cone.axis).powi(2)).max(0.0).sqrt();
        let end = |p: DVec3, radius: f64| cone.locate(p).0 + radius * across;
        let far = end(self.base, self.radii[0]).max(end(self.apex, self.radii[1]));
        Some(Coverage { overlap, outline: Outline::Polygon(outline), far, doubtful: false })
    }

    /// The depth at which the ray through a place meets it.
    pub fn depth(&self, cone: &Cone, place: DVec2) -> Option<f64> {
        let ray = cone.ray(place);
        self.body.intersect(&ray, ray.t_max)
    }

    /// The angles between which it is visible.
    fn visible(&self, cone: &Cone) -> Option<(f64, f64)> {
        let radius = cone.locate(self.middle()).2;
        // towards the apex, how large the side is there, and whether the rays come from it
        let (towards, reach, from_apex) = if cone.spread == 0.0 {
            (-cone.axis, self.slope * -cone.axis.dot(self.axis), true)
        } else {
            let apex = cone.origin - cone.axis * (cone.radius / cone.spread) - self.base;
            let from_apex = cone.spread > 0.0 || radius < 0.0;
            (apex, self.radii[0] + self.slope * apex.dot(self.axis), from_apex)
        };
        let (mut towards, mut reach) =
            (DVec2::new(towards.dot(self.right), towards.dot(self.up)), reach);
        // rays that run towards the apex, and sides that show the inside, are seen the other way
        if from_apex == self.shows_inside {
            (towards, reach) = (-towards, -reach);
        }
        let distance = towards.length();
        if reach >= distance {
            return None;
        }
        let middle = towards.to_angle();
        let half =
            if reach <= -distance { std::f64::consts::PI } else { (reach / distance).acos() };
        Some((middle - half, middle + half))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tracers::cone::disc_overlap::tests::counted;

    #[test]
    fn cone_coverage_equals_the_share_of_rays() {
        let side = |base: [f64; 3], apex: [f64; 3], r0: f64, r1: f64| {
            let (base, apex) = (DVec3::from(base), DVec3::from(apex));
            Side::new(0, &scene_loading::Cone { base, base_radius: r0, apex, apex_radius: r1 })
        };
        let eye = Cone::new(DVec3::ZERO, DVec3::Z, 0.0, 0.05);
        let beam = Cone::new(DVec3::ZERO, DVec3::Z, 0.5, 0.0);
        let lens = Cone::new(DVec3::ZERO, DVec3::Z, 1.0, -0.06);
        for cone in [eye, beam, lens] {
            for sign in [1.0, -1.0] {
                let sides = [
                    side([-3.0, 0.1, 9.0], [3.0, 0.2, 10.0], 0.2, 0.2),
                    side([0.1, 0.0, 10.0], [0.0, 0.2, 12.0], 0.4, 0.1),
                    side([0.1, 0.0, 10.0], [0.0, 0.2, 12.0], 0.1, 0.4),
                    side([0.2, 0.0, 9.0], [1.4, 0.5, 10.0], 0.2, 0.3),
                ];
                for mut side in sides {
                    side.shows_inside = sign < 0.0;
                    let [r0, r1] = side.radii;
                    side.body = Body::new(side.base, r0 * sign, side.apex, r1 * sign);
                    let share = side.cover(&cone).map_or(0.0, |c| c.overlap.share);
                    let (expected, _) = counted(200, |place| side.depth(&cone, place).is_some());
                    let Side { base, radii, .. } = side;
                    let what = format!("{share} {expected} {base:?} {radii:?} {sign} {cone:?}");
                    assert!((share - expected).abs() < 0.015, "{what}");
                }
            }
        }
    }
}
