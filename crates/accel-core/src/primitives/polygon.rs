//! Planar polygons with any number of vertices, concave ones too, two-sided.
//!
//! The crossing test runs in the sheared space of the watertight triangle test (see `triangle.rs`).
//! On which side of an edge a ray passes is the exact sign of a determinant of two sheared
//! vertices, which depend on the vertex and the ray alone. So the neighbours of an edge decide it
//! alike, whatever their winding, and a triangle beside a polygon does so too: no ray passes
//! between them. Inside is even-odd (M. Shimrat, "Algorithm 112: Position of point relative to
//! polygon", CACM 5(8), 1962): an edge that is passed twice, as of a bridge to a hole, counts for
//! nothing.
//!
//! Where a polygon is seen nearly edge-on, or is not planar, the parameter of its plane may be that
//! of a point far off. It is bounded then by the outline: see `chord.rs`.

use glam::DVec3;

use crate::geometry::aabb::Aabb;
use crate::geometry::ray::Ray;
use crate::geometry::scalar::{Scalar, Vec3, Vector};
use crate::primitives::chord::Chord;
use crate::primitives::collinear::are_collinear;
use crate::primitives::precise::ShearedVertices;
use crate::primitives::shear::{Shear, near_factor};
use crate::primitives::support::{Ball, balls_around, distance_to_points, extent_of_points};
use crate::primitives::watertight::edge_function;

/// By how many epsilons of a ray's distance on an axis the numerator of a plane's parameter is off,
/// unless every rounding is at its worst at once.
const PLANE_ULPS: f64 = 1.5;

/// By how many epsilons of the scene's largest coordinate a hit may lie outside of the polygon's
/// bounds: as far as that of a triangle does across the ray.
const GRAZING_ULPS: f64 = 37.0;

/// A polygon's plane and where its vertices are.
#[derive(Debug, Clone, Copy)]
pub struct Polygon<S: Scalar> {
    /// Unit normal (Newell), zero for a polygon without area.
    pub normal: Vec3<S>,
    /// A point of the plane.
    anchor: Vec3<S>,
    /// How steeply a ray must meet the plane for its parameter to be precise: see
    /// [`Polygon::is_grazed`].
    least_slope: S,
    first: u32,
    count: u32,
    bounds: Aabb<S>,
}

impl<S: Scalar> Polygon<S> {
    /// Appends the vertices to `store` and returns the polygon over them; none below three.
    pub fn new(vertices: &[glam::DVec3], store: &mut Vec<[S; 3]>) -> Option<Self> {
        if vertices.len() < 3 {
            return None;
        }
        let first = store.len() as u32;
        let mut bounds = Aabb::empty();
        for &v in vertices {
            let v = Vec3::<S>::from_dvec3(v);
            bounds = bounds.union(Aabb { min: v, max: v });
            store.push(v.to_array());
        }
        let rounded: Vec<_> =
            vertices.iter().map(|&v| Vec3::<S>::from_dvec3(v).to_dvec3()).collect();
        let normal = if are_collinear(&rounded) { DVec3::ZERO } else { newell_normal(vertices) };
        let polygon = Self {
            normal: Vec3::<S>::from_dvec3(normal),
            anchor: Vec3::<S>::from_dvec3(vertices[0]),
            least_slope: S::ZERO,
            first,
            count: vertices.len() as u32,
            bounds,
        };
        let epsilon = S::EPSILON.to_f64();
        let ulp = epsilon * bounds.magnitude().to_f64();
        let off_plane = polygon.off_plane(store).max(0.0) / ulp.max(f64::MIN_POSITIVE);
        // four magnitudes are in `Shear::fine`
        let allowed = GRAZING_ULPS / 4.0 * near_factor::<S>().to_f64();
        let least_slope = S::from_f64((PLANE_ULPS + off_plane) / allowed);
        Some(Self { least_slope, ..polygon })
    }

    /// The hit with the plane if it lies in `[ray.t_min, t_max]` and inside the outline.
    #[inline(always)]
    pub fn intersect(
        &self,
        store: &[[S; 3]],
        ray: &Ray<S>,
        shear: &Shear<S>,
        t_max: S,
    ) -> Option<S> {
        let along = self.normal.dot(ray.direction);
        let t = self.normal.dot(self.anchor - ray.origin) / along;
        let is_within = t >= ray.t_min && t <= t_max;
        let is_grazed = self.is_grazed(along, shear);
        if !(is_within || is_grazed) {
            return None;
        }
        self.hit_within(store, ray, shear, t_max, (!is_grazed).then_some(t))
    }

    /// The same of a ray that meets the plane at `plane`, unless it is grazed.
    // compiled once, not into each traversal of each structure: most rays are rejected before
    #[inline(never)]
    fn hit_within(
        &self,
        store: &[[S; 3]],
        ray: &Ray<S>,
        shear: &Shear<S>,
        t_max: S,
        plane: Option<S>,
    ) -> Option<S> {
        let is_small = shear.is_too_small();
        if !(is_small || encloses_axis(self.outline(store), shear)) {
            return None;
        }
        if plane.is_some() && !is_small {
            return plane;
        }
        let t = self.bounded_hit(store, ray, shear, plane)?;
        (t >= ray.t_min && t <= t_max).then_some(t)
    }

    /// Returns whether the parameter of the plane may be that of a point outside of the padded
    /// bounds.
    ///
    /// It is off by the rounding of the numerator, [`PLANE_ULPS`] of the distance of the origin on
    /// an axis from the farthest vertex, over the cosine of ray and normal; and what vertices lie
    /// off the plane is enlarged likewise. That is compared with [`GRAZING_ULPS`]. NaN, in the plane
    /// or without a normal, is grazing.
    #[inline(always)]
    fn is_grazed(&self, along: S, shear: &Shear<S>) -> bool {
        let slope = (along * shear.depth_scale()).abs() * shear.fine;
        let is_steep = slope >= self.least_slope * shear.near;
        !is_steep
    }

    /// Intersects a polygon that is grazed, or with a ray whose components are too small for the
    /// scalar. `plane` is the parameter of its plane, if precise.
    #[cold]
    #[inline(never)]
    fn bounded_hit(
        &self,
        store: &[[S; 3]],
        ray: &Ray<S>,
        shear: &Shear<S>,
        plane: Option<S>,
    ) -> Option<S> {
        if self.normal == Vec3::<S>::splat(S::ZERO) {
            return None;
        }
        let sheared = ShearedVertices::by(ray, shear);
        let chord = Chord::of(self.outline(store).iter().map(|v| sheared.vertex(v)))?;
        if plane.is_some() {
            return plane;
        }
        let normal = self.normal.to_dvec3();
        let distance = normal.dot(self.anchor.to_dvec3() - ray.origin.to_dvec3());
        let plane = distance / normal.dot(ray.direction.to_dvec3());
        let scale = shear.depth_scale().to_f64();
        // of sheared vertices: 4 epsilons
        let rounding = 4.0 * S::EPSILON.to_f64() / near_factor::<S>().to_f64();
        let rounding = if shear.is_too_small() { 0.0 } else { shear.near.to_f64() * rounding };
        Some(S::from_f64(chord.depth_near(plane / scale, rounding) * scale))
    }

    /// Smallest and largest dot product of `direction` with a point of the outline, or with one of
    /// the plane as far off the outline as a vertex is off the plane.
    pub(super) fn extent(&self, store: &[[S; 3]], direction: DVec3) -> (f64, f64) {
        let (lo, hi) = extent_of_points(self.outline(store), direction);
        let off = self.off_plane(store) * direction.length();
        (lo - off, hi + off)
    }

    /// Largest distance from `from` to such a point, world units.
    pub(super) fn farthest(&self, store: &[[S; 3]], from: DVec3) -> f64 {
        distance_to_points(self.outline(store), from) + self.off_plane(store)
    }

    /// See [`crate::primitives::Primitives::hull`]: balls as large as the vertices are off the plane.
    pub(super) fn hull(&self, store: &[[S; 3]], balls: &mut Vec<Ball>) {
        balls_around(self.outline(store), self.off_plane(store).max(0.0), balls);
    }

    /// How far vertices lie off the plane: 0 but for rounding if the polygon is planar.
    fn off_plane(&self, store: &[[S; 3]]) -> f64 {
        let normal = self.normal.to_dvec3();
        let (lo, hi) = extent_of_points(self.outline(store), normal);
        let plane = self.anchor.to_dvec3().dot(normal);
        (hi - plane).max(plane - lo)
    }

    #[inline(always)]
    fn outline<'a>(&self, store: &'a [[S; 3]]) -> &'a [[S; 3]] {
        &store[self.first as usize..][..self.count as usize]
    }

    /// Bounds of the vertices.
    #[inline(always)]
    pub fn bounds(&self) -> Aabb<S> {
        self.bounds
    }
}

/// Even-odd crossing test of the sheared outline around the ray.
#[inline(always)]
fn encloses_axis<S: Scalar>(outline: &[[S; 3]], shear: &Shear<S>) -> bool {
    let Some((first, others)) = outline.split_first() else { return false };
    let first = shear.apply(first);
    let (mut inside, mut p) = (false, first);
    for v in others {
        let q = shear.apply(v);
        inside ^= passes_right(&p, &q);
        p = q;
    }
    inside ^ passes_right(&p, &first)
}

/// Returns whether an edge crosses the x axis at x > 0: exactly there, whatever its direction,
/// since its neighbours must not both refuse it.
#[inline(always)]
fn passes_right<S: Scalar>(p: &[S; 3], q: &[S; 3]) -> bool {
    if (p[1] > S::ZERO) == (q[1] > S::ZERO) {
        return false;
    }
    let side = edge_function(p[0], q[1], q[0], p[1]);
    side != S::ZERO && (side > S::ZERO) == (q[1] > p[1])
}

/// The unit normal by Newell's method (sum of cross products); zero when there is no area.
///
/// Parts of an outline that crosses itself may cancel in that sum: where little of it is left, the
/// normal is that of a large triangle of vertices.
pub fn newell_normal(vertices: &[glam::DVec3]) -> glam::DVec3 {
    let mut normal = glam::DVec3::ZERO;
    let mut area = 0.0;
    let Some(&origin) = vertices.first() else { return normal };
    // by a power of two: products of what is small do not underflow
    let size = vertices.iter().map(|v| (*v - origin).abs().max_element()).fold(0.0, f64::max);
    let unit = size.to_unit_size();
    let far = |v: DVec3| (v - origin) * unit;
    for (i, &p) in vertices.iter().enumerate() {
        let q = vertices[(i + 1) % vertices.len()];
        let part = far(p).cross(far(q));
        normal += part;
        area += part.length();
    }
    if normal.length() <= CANCELLED * area {
        normal = largest_triangle(vertices.iter().map(|&v| far(v)), normal);
    }
    normal.normalize_or_zero()
}

/// What of a sum of cross products is left, over the sum of their lengths, where the rounding of
/// vertices far from 0 may turn it: then the largest triangle says more.
const CANCELLED: f64 = 1.0 / 64.0;

/// The cross product of the longest of these vectors and the one farthest from its line; it points
/// to the side of `likely` if that is known.
fn largest_triangle(far: impl Iterator<Item = DVec3> + Clone, likely: DVec3) -> DVec3 {
    let by_length = |a: &DVec3, b: &DVec3| a.length_squared().total_cmp(&b.length_squared());
    let longest = far.clone().max_by(by_length).unwrap_or(DVec3::ZERO);
    let normal = far.map(|v| longest.cross(v)).max_by(by_length).unwrap_or(DVec3::ZERO);
    if normal.dot(likely) < 0.0 { -normal } else { normal }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::dvec3;

    fn hits(outline: &[(f64, f64)], x: f64, y: f64) -> bool {
        let mut store = Vec::new();
        let vertices: Vec<_> = outline.iter().map(|&(x, y)| dvec3(x, y, 0.0)).collect();
        let p = Polygon::<f32>::new(&vertices, &mut store).unwrap();
        let ray = Ray::<f32>::new(glam::vec3(x as f32, y as f32, 2.0), -glam::Vec3::Z);
        p.intersect(&store, &ray, &Shear::of(&ray, 2.0), f32::INFINITY).is_some()
    }

    #[test]
    fn concave_outline() {
        // HARD_CASES G12: area 0.4, which a fan would take for 3.6
        let v = [(0.0, 0.0), (2.0, 0.0), (0.2, 0.2), (0.0, 2.0)];
        let n = 200;
        let middle = |i: i32| 2.0 * (f64::from(i) + 0.5) / 200.0;
        let inside = (0..n * n).filter(|i| hits(&v, middle(i % n), middle(i / n))).count();
        let area = 4.0 * inside as f64 / f64::from(n * n);
        // exact area by the shoelace formula: 0.4
        assert!((area - 0.4).abs() < 0.02, "{area}");
    }

    #[test]
    fn rounding_far_from_0_does_not_turn_a_bow_tie() {
        let outline = [(0.0, 0.0), (2.0, 2.0), (2.0, 0.0), (0.0, 2.0)];
        for i in 0..500 {
            let about = dvec3(f64::from(i).sin(), f64::from(i * i).cos(), 0.5).normalize();
            let turn = glam::DQuat::from_axis_angle(about, f64::from(i));
            let place = |(x, y)| turn * dvec3(x, y, 0.0) + about * 60.0;
            let normal = newell_normal(&outline.map(|p| place(p).as_vec3().as_dvec3()));
            assert!(normal.dot(turn * DVec3::Z).abs() > 0.999_999, "{i}: {normal}");
        }
    }

    #[test]
    fn neighbours_share_their_edge_without_gap_or_overlap() {
        let a = [(0.0, 0.0), (1.0, 0.1), (1.1, 0.9), (0.0, 1.0)];
        let b = [(1.0, 0.1), (2.0, 0.0), (2.0, 1.0), (1.1, 0.9)];
        for i in 1..1000 {
            let s = f64::from(i) / 1000.0 * 0.8;
            let (x, y) = (1.0 + 0.125 * s, 0.1 + s);
            assert!(hits(&a, x, y) != hits(&b, x, y), "at {x} {y}");
        }
    }

    #[test]
    fn degenerate_outlines() {
        let edge = Polygon::<f32>::new(&[DVec3::ZERO, DVec3::X], &mut Vec::new());
        assert!(edge.is_none());
        assert!(!hits(&[(0.0, 0.0), (1.0, 0.0), (2.0, 0.0)], 0.5, 0.0));
    }
}
