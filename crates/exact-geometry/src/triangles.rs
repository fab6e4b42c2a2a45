//! Which triangles a line meets, by exact signs.
//!
//! J. R. Shewchuk, "Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric
//! Predicates", 1997, through the crate `robust`. Edges and corners belong to the triangle; a
//! triangle in the plane of the ray is not met. Parameters and depths are computed in twice the
//! digits of f64: from a far origin f64 has none left.

use glam::DVec3;
use robust::{Coord3D, orient3d};

use crate::double_double::{cross, difference, dot, vector};

/// The corners of a triangle.
pub type Corners = [DVec3; 3];

/// A triangle that the line of the ray meets, or passes closely.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LineCrossing {
    pub id: u32,
    /// The ray's parameter in its plane; correct to a few ulps of f64.
    pub t: f64,
    /// How deep inside the triangle: the smallest barycentric coordinate. The sign is exact.
    pub depth: f64,
    /// By how much `t` and `depth` change, at most, when the ray is moved sideways by a unit of
    /// length: much, where it runs nearly in the triangle's plane.
    pub blur: Blur,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Blur {
    pub t: f64,
    /// Depth of the barycentric coordinates.
    pub depth: f64,
}

impl LineCrossing {
    /// Inside, on an edge or on a corner.
    pub fn is_hit(&self) -> bool {
        self.depth >= 0.0
    }
}

/// Triangles with balls around them, so that those far from a ray are left out quickly.
#[derive(Debug, Clone)]
pub struct Soup {
    triangles: Vec<Corners>,
    /// Centre and squared radius of each ball.
    balls: Vec<(DVec3, f64)>,
    bounds: [DVec3; 2],
}

impl Soup {
    pub fn new(triangles: &[Corners]) -> Self {
        let ball = |&[a, b, c]: &Corners| {
            let centre = (a + b + c) / 3.0;
            let farthest = [a, b, c].map(|p| p.distance_squared(centre));
            (centre, farthest.into_iter().fold(0.0, f64::max))
        };
        let corners = triangles.as_flattened().iter();
        let empty = [DVec3::INFINITY, DVec3::NEG_INFINITY];
        let bounds = corners.fold(empty, |[low, high], p| [low.min(*p), high.max(*p)]);
        let balls = triangles.iter().map(ball).collect();
        Self { triangles: triangles.to_vec(), balls, bounds }
    }

    /// The lower and the upper corner of the box around all triangles.
    pub fn bounds(&self) -> [DVec3; 2] {
        self.bounds
    }
}

/// A ray as two points of its line.
#[derive(Debug, Clone, Copy)]
pub struct ExactRay {
    from: DVec3,
    to: DVec3,
}

impl ExactRay {
    /// `None` where origin + direction is not exact in f64.
    pub fn new(from: DVec3, along: DVec3) -> Option<Self> {
        let to = from + along;
        let is_exact = (0..3).all(|k| two_sum_error(from[k], along[k]) == 0.0);
        is_exact.then_some(Self { from, to })
    }

    /// All triangles whose plane the line crosses no farther than `margin` (in barycentric
    /// coordinates) outside, or that it would meet when moved by `shift`, a length; by rising
    /// parameter; equal ones by id.
    pub fn meetings(&self, soup: &Soup, margin: f64, shift: f64) -> Vec<LineCrossing> {
        let near = |m: &LineCrossing| m.depth >= -(margin + shift * m.blur.depth);
        let along = self.to - self.from;
        // barycentric coordinates of at least -margin: their sizes sum up to 1 + 6 margin at most
        let grown = (1.1 + 6.0 * margin) * (1.1 + 6.0 * margin);
        let limit = grown * along.length_squared();
        let close = (0_u32..).zip(&soup.balls).filter(|(_, (centre, radius))| {
            let nearest = (*centre - self.from).cross(along).length_squared();
            let radius = radius + shift * shift;
            // false for NaN too: overflow must not lose a triangle
            let is_far = nearest > radius * limit && nearest.is_finite();
            !is_far
        });
        let all = close.filter_map(|(id, _)| self.meeting(id, soup.triangles.get(id as usize)?));
        let mut found: Vec<LineCrossing> = all.filter(near).collect();
        found.sort_by(|a, b| a.t.total_cmp(&b.t).then(a.id.cmp(&b.id)));
        found
    }

    /// Where the line crosses the plane; `None` when they are parallel.
    fn meeting(&self, id: u32, &[a, b, c]: &Corners) -> Option<LineCrossing> {
        let along = self.to - self.from;
        let across = cross(difference(b, a), difference(c, a));
        let slope = dot(across, vector(along));
        if slope.high == 0.0 {
            return None;
        }
        let [from_a, from_b, from_c] =
            [difference(a, self.from), difference(b, self.from), difference(c, self.from)];
        let depth = |p, q| (dot(cross(p, q), vector(along)) / slope).high;
        let depth = depth(from_b, from_c).min(depth(from_c, from_a)).min(depth(from_a, from_b));
        // all three may be NaN
        let depth = depth.min(f64::INFINITY);
        let depth = if self.is_met(&[a, b, c]) { depth.max(0.0) } else { depth.min(BELOW_ZERO) };
        let t = (dot(across, from_a) / slope).high;
        let normal = length(DVec3::new(across[0].high, across[1].high, across[2].high));
        let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
        // of the angle between line and plane
        let sine = slope.high.abs() / (normal * along.length());
        let blur = Blur { t: 1.0 / (sine * along.length()), depth: longest / (normal * sine) };
        Some(LineCrossing { id, t, depth, blur })
    }

    /// Whether the line passes within the triangle or through its border, by exact signs.
    fn is_met(&self, [a, b, c]: &Corners) -> bool {
        let coord = |p: DVec3| Coord3D { x: p.x, y: p.y, z: p.z };
        let side =
            |p: &DVec3, q: &DVec3| orient3d(coord(self.from), coord(self.to), coord(*p), coord(*q));
        let sides = [side(b, c), side(c, a), side(a, b)];
        sides.iter().all(|s| *s >= 0.0) || sides.iter().all(|s| *s <= 0.0)
    }
}

/// Length of a vector whose square may be too small or too large for f64.
fn length(v: DVec3) -> f64 {
    let largest = v.abs().max_element();
    if largest > 0.0 { (v / largest).length() * largest } else { 0.0 }
}

/// The largest number below zero.
const BELOW_ZERO: f64 = -f64::from_bits(1);

/// Rounding error of `a + b` (Knuth's two-sum).
fn two_sum_error(a: f64, b: f64) -> f64 {
    let sum = a + b;
    let b_part = sum - a;
    (a - (sum - b_part)) + (b - b_part)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::dvec3;

    const TRIANGLE: Corners = [DVec3::ZERO, dvec3(4.0, 0.0, 0.0), dvec3(0.0, 4.0, 0.0)];

    fn meetings(from: DVec3, along: DVec3, margin: f64, shift: f64) -> Vec<LineCrossing> {
        ExactRay::new(from, along).unwrap().meetings(&Soup::new(&[TRIANGLE]), margin, shift)
    }

    fn depth(x: f64, y: f64) -> f64 {
        let found = meetings(dvec3(x, y, -2.0), dvec3(0.0, 0.0, 4.0), 9.0, 0.0);
        assert_eq!((found.len(), found[0].t), (1, 0.5));
        found[0].depth
    }

    #[test]
    fn slanting_rays_blur_the_crossing() {
        let along = dvec3(8.0, 0.0, 1.0);
        // a unit sideways is 8 along the plane and more: 2 in barycentric coordinates
        let LineCrossing { t, blur, .. } = meetings(dvec3(-7.0, 1.0, -1.0), along, 0.0, 0.0)[0];
        assert!(t == 1.0 && (1.0..1.1).contains(&blur.t), "{blur:?}");
        assert!((2.8..2.9).contains(&blur.depth), "{blur:?}");
        let beside = dvec3(-12.0, 1.0, -1.0);
        assert!(meetings(beside, along, 0.0, 0.1).is_empty());
        assert_eq!(meetings(beside, along, 0.0, 0.6).len(), 1);
    }

    #[test]
    fn one_ulp_beside_an_edge_is_outside() {
        assert_eq!(depth(1.0, 1.0), 0.25);
        assert_eq!(depth(2.0, 2.0), 0.0);
        assert!(depth(2.0, 2.0_f64.next_up()) < 0.0 && depth(2.0, 2.0_f64.next_down()) > 0.0);
        assert!(depth(0.0, 0.0) == 0.0 && depth(-f64::MIN_POSITIVE, 1.0) < 0.0);
    }

    #[test]
    fn inexact_rays_are_refused() {
        let ray = |x: f64| ExactRay::new(dvec3(1.0, 0.0, 0.0), dvec3(x, 0.0, 1.0));
        assert!(ray(0.5).is_some() && ray(1e-30).is_none());
    }
}
