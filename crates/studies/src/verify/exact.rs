//! The exact oracle: which triangles a ray meets, decided by exact predicates, and the closest hit
//! that a round may expect of that.
//!
//! J. R. Shewchuk, "Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric
//! Predicates", 1997, through the crate `robust`. Edges and corners belong to the triangle; a
//! triangle in the plane of the ray is not met. Parameters and depths are computed in twice the
//! digits of f64: from a far origin f64 has none left.

use accel_core::{Ray, Scalar, Vector};
use glam::DVec3;
use robust::{Coord3D, orient3d};

use super::double_double::{cross, difference, dot, vector};
use super::round::{Corners, OracleAnswer};

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

    /// The distance from there to the farthest corner on any axis; of far origins, to where
    /// the product moves them first (`accel_core::geometry::far_ray`).
    pub fn reach(&self, from: DVec3) -> f64 {
        let [low, high] = self.bounds;
        let far = (from - low).abs().max((from - high).abs()).max_element();
        far.min(9.0 * low.abs().max(high.abs()).max_element())
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
    pub fn new<S: Scalar>(ray: &Ray<S>) -> Option<Self> {
        let (from, along) = (ray.origin.to_dvec3(), ray.direction.to_dvec3());
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

/// How far outside a triangle, in barycentric coordinates, rounding may still find a hit; and how
/// far inside it may still lose one, where no neighbour catches it.
const UNCLEAR: f64 = 1e-3;

/// On a closed mesh, or within a sheet: there is a hit about where the exact one is. Which of the
/// triangles at an edge is hit is left to rounding.
pub fn on_mesh<S: Scalar>(mesh: &Soup, ray: &Ray<S>, slack: f64) -> Option<OracleAnswer> {
    let meetings = ExactRay::new(ray)?.meetings(mesh, 0.0, 0.0);
    let first = meetings.iter().find(|m| m.is_hit() && m.t > 0.0)?;
    Some(OracleAnswer::hit_at(first.t, slack))
}

/// Expectation if all arithmetic of the primitive test is exact (integers, the largest component of
/// the direction a power of two): the lowest id among the nearest, and `t` to an ulp.
pub fn on_lattice<S: Scalar>(triangles: &Soup, ray: &Ray<S>) -> Option<OracleAnswer> {
    let meetings = ExactRay::new(ray)?.meetings(triangles, 0.0, 0.0);
    let mut hits = meetings.iter().filter(|m| m.is_hit() && is_within(ray, m.t));
    let Some(first) = hits.next() else { return Some(OracleAnswer::Miss) };
    let slack = first.t.abs() * S::EPSILON.to_f64();
    let equal = |m: &&LineCrossing| (m.t - first.t).abs() <= 1e-12 * first.t.abs();
    let tied = hits.clone().filter(equal).map(|m| m.id).fold(first.id, u32::min);
    // two parameters that differ, but not in this precision: rounding decides
    let is_clear = hits.filter(|m| !equal(m)).all(|m| m.t - first.t > 4.0 * slack);
    Some(OracleAnswer::Hit { id: is_clear.then_some(tied), t: [first.t - slack, first.t + slack] })
}

/// Epsilons of the distance to the farthest corner by which the rounding of differences to the
/// origin, of shears and of products may move a ray, together.
const SHIFT: f64 = 16.0;

/// Among loose triangles: the hit, where it is clear of all edges and of other triangles in the
/// same place; otherwise whatever brute force says. Where the ray runs nearly in the plane of a
/// triangle, less is clear.
pub fn in_soup<S: Scalar>(triangles: &Soup, ray: &Ray<S>) -> Option<OracleAnswer> {
    in_soup_within(S::EPSILON.to_f64(), triangles, ray)
}

/// The same for a ray whose components are off by as much as `epsilon` of the largest one.
pub fn in_soup_within<S: Scalar>(epsilon: f64, soup: &Soup, ray: &Ray<S>) -> Option<OracleAnswer> {
    let shift = SHIFT * epsilon * soup.reach(ray.origin.to_dvec3());
    let meetings = ExactRay::new(ray)?.meetings(soup, UNCLEAR, shift);
    let slack = |m: &LineCrossing| (m.t.abs() * UNCLEAR).max(m.blur.t * shift);
    let mut ahead = meetings.iter().filter(|m| m.t > -UNCLEAR - slack(m));
    let Some(first) = ahead.next() else { return Some(OracleAnswer::Miss) };
    let is_inside = |m: &LineCrossing| m.depth >= UNCLEAR.max(m.blur.depth * shift);
    if !is_inside(first) || first.t < UNCLEAR + slack(first) {
        return Some(OracleAnswer::Anything);
    }
    let twin = |m: &&LineCrossing| m.t == first.t && m.depth == first.depth;
    let end = first.t + slack(first);
    let is_clear = ahead.all(|m| twin(&m) || m.t - slack(m) > end);
    let id = is_clear.then_some(first.id);
    // another one may be first
    let low = meetings.iter().map(|m| m.t - slack(m)).filter(|t| *t > 0.0).fold(end, f64::min);
    Some(OracleAnswer::Hit { id, t: [low.min(first.t - slack(first)), end] })
}

fn is_within<S: Scalar>(ray: &Ray<S>, t: f64) -> bool {
    ray.t_min.to_f64() <= t && t <= ray.t_max.to_f64()
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::dvec3;

    const TRIANGLE: Corners = [DVec3::ZERO, dvec3(4.0, 0.0, 0.0), dvec3(0.0, 4.0, 0.0)];

    fn depth(x: f64, y: f64) -> f64 {
        let ray = Ray::<f64>::new(dvec3(x, y, -2.0), dvec3(0.0, 0.0, 4.0));
        let found = ExactRay::new(&ray).unwrap().meetings(&Soup::new(&[TRIANGLE]), 9.0, 0.0);
        assert_eq!((found.len(), found[0].t), (1, 0.5));
        found[0].depth
    }

    #[test]
    fn slanting_rays_blur_the_crossing() {
        let ray = Ray::<f64>::new(dvec3(-7.0, 1.0, -1.0), dvec3(8.0, 0.0, 1.0));
        let found = ExactRay::new(&ray).unwrap().meetings(&Soup::new(&[TRIANGLE]), 0.0, 0.0);
        // a unit sideways is 8 along the plane and more: 2 in barycentric coordinates
        let LineCrossing { t, blur, .. } = found[0];
        assert!(t == 1.0 && (1.0..1.1).contains(&blur.t), "{blur:?}");
        assert!((2.8..2.9).contains(&blur.depth), "{blur:?}");
        let beside = Ray::<f64>::new(dvec3(-12.0, 1.0, -1.0), dvec3(8.0, 0.0, 1.0));
        let beside = ExactRay::new(&beside).unwrap();
        let soup = Soup::new(&[TRIANGLE]);
        assert!(beside.meetings(&soup, 0.0, 0.1).is_empty());
        assert_eq!(beside.meetings(&soup, 0.0, 0.6).len(), 1);
    }

    #[test]
    fn a_triangle_that_is_nearly_a_line_is_not_judged() {
        // the square of its normal is below f64's numbers; found by `rtbench verify` with 10^6 rays
        let line = [DVec3::ZERO, dvec3(1.0, 1e-318, 0.0), dvec3(2.0, 0.0, 0.0)];
        let behind = [dvec3(-3.0, -3.0, 1.0), dvec3(3.0, -3.0, 1.0), dvec3(0.0, 3.0, 1.0)];
        let ray = Ray::<f64>::new(dvec3(1.0, 0.0, -1.0), dvec3(0.0, 0.0, 1.0));
        let answer = |triangles: &[Corners]| in_soup(&Soup::new(triangles), &ray);
        assert_eq!(answer(&[line, behind]), Some(OracleAnswer::Anything));
        assert!(matches!(answer(&[behind]), Some(OracleAnswer::Hit { id: Some(0), .. })));
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
        let ray = |x: f64| Ray::<f64>::new(dvec3(1.0, 0.0, 0.0), dvec3(x, 0.0, 1.0));
        assert!(ExactRay::new(&ray(0.5)).is_some() && ExactRay::new(&ray(1e-30)).is_none());
    }
}
