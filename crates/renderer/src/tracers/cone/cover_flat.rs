//! Share of a cone covered by a polygon, a triangle, a patch, or a plane larger than the cone.
//!
//! Paper: J. Amanatides, "Ray Tracing with Cones", SIGGRAPH 1984, which replaces the polygon by
//! the edges nearest to the axis. Deviation: the polygon is seen from the apex, as the outline on
//! the cross-section that it has there, and its share of the disc is exact. The clipping is that
//! of I. Sutherland, G. Hodgman, "Reentrant Polygon Clipping", CACM 17(1), 1974; concave outlines
//! get double edges by it, which have no area.

use glam::{DVec2, DVec3};

use super::circular_cone::Cone;
use super::coverage::{Coverage, Outline};
use super::disc_overlap::{Overlap, of_polygon};

/// Outlines are cut off so many radii from the axis: what is beyond covers nothing.
const WINDOW: f64 = 2.0;

/// A focus and an apex are left out by this part of the cone's largest radius.
const LEAST_RADIUS: f64 = 1e-7;

pub struct FlatCoverage {
    /// Unit normal; zero where it has no area.
    pub normal: DVec3,
    pub first: usize,
    pub count: usize,
}

impl FlatCoverage {
    pub fn cover(&self, cone: &Cone, corners: &[DVec3]) -> Option<Coverage> {
        let &anchor = corners.first()?;
        let (overlap, outline, deepest) = project(cone, corners)?;
        // the plane is deepest at the edge of the disc, in the direction in which it recedes
        let (across, along) = self.slope(cone);
        let reach = across.length();
        let height = self.normal.dot(anchor - cone.origin);
        let depth = |q: f64| {
            let rate = along + cone.spread * q;
            let depth = (height - cone.radius * q) / rate;
            if rate * along > 0.0 { depth } else { f64::INFINITY }
        };
        let far = depth(reach).max(depth(-reach)).min(deepest);
        Some(Coverage { overlap, outline: Outline::Polygon(outline), far, doubtful: false })
    }

    pub fn depth(&self, cone: &Cone, anchor: DVec3, place: DVec2) -> Option<f64> {
        let (across, along) = self.slope(cone);
        let q = across.dot(place);
        let height = self.normal.dot(anchor - cone.origin);
        let depth = (height - cone.radius * q) / (along + cone.spread * q);
        depth.is_finite().then_some(depth)
    }

    /// The normal by the directions of the cone.
    fn slope(&self, cone: &Cone) -> (DVec2, f64) {
        let n = self.normal;
        (DVec2::new(n.dot(cone.right), n.dot(cone.up)), n.dot(cone.axis))
    }
}

/// A corner before the division by the radius: where it lies across, the radius there, the depth,
/// and the height above the surface that the cone leaves.
#[derive(Clone, Copy)]
struct Corner {
    across: DVec2,
    radius: f64,
    depth: f64,
    height: f64,
}

impl Corner {
    fn mix(self, other: Self, share: f64) -> Self {
        Self {
            across: self.across.lerp(other.across, share),
            radius: self.radius + (other.radius - self.radius) * share,
            depth: self.depth + (other.depth - self.depth) * share,
            height: self.height + (other.height - self.height) * share,
        }
    }
}

/// Projects the outline of a polygon: coverage, outline in units of the radius, largest depth;
/// `None` if it covers nothing. Non-planar ones are replaced by their projection.
pub fn project(cone: &Cone, corners: &[DVec3]) -> Option<(Overlap, Vec<DVec2>, f64)> {
    let plane = cone.left.and_then(|left| left.plane);
    let located: Vec<Corner> = corners
        .iter()
        .map(|&p| {
            let (depth, across, radius) = cone.locate(p);
            let height = plane.map_or(1.0, |(normal, at)| normal.dot(p) - at);
            Corner { across, radius, depth, height }
        })
        .collect();
    let largest = located.iter().map(|c| c.radius.abs()).fold(cone.radius, f64::max);
    let least = LEAST_RADIUS * largest;
    let mut outline = Vec::new();
    let mut deepest = f64::NEG_INFINITY;
    let mut total: Option<Overlap> = None;
    // in front of a focus the radius is above 0, behind it below
    for side in [1.0, -1.0] {
        if side < 0.0 && (cone.spread >= 0.0 || located.iter().all(|c| c.radius >= -least)) {
            continue;
        }
        let mut part = located.clone();
        clip(&mut part, |c| c.radius * side - least);
        clip(&mut part, |c| c.depth - cone.begin);
        if cone.end.is_finite() {
            clip(&mut part, |c| cone.end - c.depth);
        }
        if plane.is_some() {
            clip(&mut part, |c| c.height);
        }
        clip(&mut part, |c| c.radius * side * WINDOW - c.across.x);
        clip(&mut part, |c| c.radius * side * WINDOW + c.across.x);
        clip(&mut part, |c| c.radius * side * WINDOW - c.across.y);
        clip(&mut part, |c| c.radius * side * WINDOW + c.across.y);
        if part.len() < 3 {
            continue;
        }
        let places: Vec<DVec2> = part.iter().map(|c| c.across / c.radius).collect();
        let overlap = of_polygon(&places);
        if overlap.share == 0.0 {
            continue;
        }
        deepest = part.iter().map(|c| c.depth).fold(deepest, f64::max);
        total = Some(total.map_or(overlap, |first| add_overlaps(first, overlap)));
        outline.extend(places);
    }
    total.map(|overlap| (overlap, outline, deepest))
}

/// The parts of one outline in front of a focus and behind it: no ray meets both.
fn add_overlaps(a: Overlap, b: Overlap) -> Overlap {
    let share = a.share + b.share;
    if share >= 1.0 {
        return Overlap::ALL;
    }
    Overlap { share, centroid: (a.centroid * a.share + b.centroid * b.share) / share }
}

/// Keeps what is on the side of a plane where `distance` is not below 0.
fn clip(corners: &mut Vec<Corner>, distance: impl Fn(&Corner) -> f64) {
    if corners.iter().all(|c| distance(c) >= 0.0) {
        return;
    }
    let Some(&last) = corners.last() else { return };
    let mut kept = Vec::with_capacity(corners.len() + 2);
    let (mut from, mut before) = (last, distance(&last));
    for &to in corners.iter() {
        let here = distance(&to);
        if (before < 0.0) != (here < 0.0) {
            kept.push(from.mix(to, before / (before - here)));
        }
        if here >= 0.0 {
            kept.push(to);
        }
        (from, before) = (to, here);
    }
    *corners = kept;
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tracers::cone::circular_cone::DepartedSurface;

    fn flat(corners: &[DVec3]) -> FlatCoverage {
        let normal = accel_core::primitives::newell_normal(corners);
        FlatCoverage { normal, first: 0, count: corners.len() }
    }

    fn cover(cone: &Cone, corners: &[DVec3]) -> f64 {
        flat(corners).cover(cone, corners).map_or(0.0, |c| c.overlap.share)
    }

    #[test]
    fn planes_half_planes_and_what_lies_behind() {
        let cone = Cone::new(DVec3::ZERO, DVec3::Z, 0.0, 0.1);
        let quad = |x0: f64, x1: f64, z0: f64, z1: f64| {
            [(x0, -1e6, z0), (x1, -1e6, z1), (x1, 1e6, z1), (x0, 1e6, z0)].map(DVec3::from)
        };
        assert_eq!(cover(&cone, &quad(-1e6, 1e6, 2.0, 2.0)), 1.0);
        assert!((cover(&cone, &quad(0.0, 1e6, 2.0, 2.0)) - 0.5).abs() < 1e-12);
        // a floor that runs from beside the eye to infinity, and one behind it
        let floor = [(-1e6, -3.0), (1e6, -3.0), (1e6, 1e6), (-1e6, 1e6)];
        let floor = floor.map(|(x, z)| DVec3::new(x, -1.0, z));
        assert!((cover(&cone, &floor) - 0.5).abs() < 1e-5);
        assert_eq!(cover(&cone, &quad(-1.0, 1.0, -2.0, -2.0)), 0.0);
        // edge on
        assert_eq!(cover(&cone, &quad(0.0, 0.0, 1.0, 9.0)), 0.0);
        // half of it is behind the surface that the cone leaves
        let left = DepartedSurface { id: 9, inwards: false, plane: Some((DVec3::Y, 0.0)) };
        let leaving = Cone { left: Some(left), ..cone };
        assert!((cover(&leaving, &quad(0.0, 1e6, 2.0, 2.0)) - 0.25).abs() < 1e-12);
        let mut short = cone;
        short.end = 1.9;
        assert_eq!(cover(&short, &quad(-1e6, 1e6, 2.0, 2.0)), 0.0);
    }

    #[test]
    fn a_plane_along_a_cone_is_met_before_the_focus_or_behind_it() {
        let cone = Cone::new(DVec3::ZERO, DVec3::Z, 1.0, -0.5);
        let wall = [(-1e6, -9.0), (1e6, -9.0), (1e6, 1e5), (-1e6, 1e5)];
        let wall = wall.map(|(y, z)| DVec3::new(0.1, y, z));
        // x > 0.1 before the focus, x < 0 behind it
        let strip = (0.1 * 0.99_f64.sqrt() + 0.1_f64.asin()) / std::f64::consts::PI;
        let share = cover(&cone, &wall);
        assert!((share - (1.0 - strip)).abs() < 1e-5, "{share} {strip}");
        let across = [(-9.0, -9.0), (9.0, -9.0), (9.0, 0.0), (-9.0, 0.0)];
        let across = |z: f64| across.map(|(x, y)| DVec3::new(x, y, z));
        assert!((cover(&cone, &across(1.9)) - 0.5).abs() < 1e-9);
        assert!((cover(&cone, &across(2.1)) - 0.5).abs() < 1e-9);
        let place = of_polygon(&project(&cone, &across(2.1)).unwrap().1).centroid;
        let before = of_polygon(&project(&cone, &across(1.9)).unwrap().1).centroid;
        assert!((place + before).length() < 1e-9 && place.length() > 0.4, "upside down");
    }

    #[test]
    fn the_deepest_point_bounds_every_ray() {
        let cone = Cone::new(DVec3::ZERO, DVec3::Z, 0.1, 0.3);
        let corners = [(-9.0, -9.0, 3.0), (9.0, -9.0, 7.0), (9.0, 9.0, 8.0), (-9.0, 9.0, 4.0)]
            .map(DVec3::from);
        let flat = flat(&corners);
        let far = flat.cover(&cone, &corners).unwrap().far;
        let edge = |k| DVec2::from_angle(f64::from(k) / 64.0 * std::f64::consts::TAU);
        let depths = (0..64).filter_map(|k| flat.depth(&cone, corners[0], edge(k)));
        let deepest = depths.fold(0.0, f64::max);
        assert!(deepest <= far && far < deepest + 0.02, "{deepest} {far}");
    }
}
