//! Planar polygons with any number of vertices, concave ones too, two-sided.
//!
//! The crossing test runs in the sheared space of the watertight triangle test (see
//! `triangle.rs`): whether a ray passes left or right of an edge depends on that edge's two
//! vertices alone, so polygons that share an edge leave no gap. Inside is even-odd (M. Shimrat,
//! "Algorithm 112: Position of point relative to polygon", CACM 5(8), 1962).

use glam::DVec3;

use crate::geometry::aabb::Aabb;
use crate::geometry::ray::Ray;
use crate::geometry::scalar::{Scalar, Vec3, Vector};
use crate::primitives::collinear::are_collinear;
use crate::primitives::shear::Shear;
use crate::primitives::support::{Ball, balls_around, distance_to_points, extent_of_points};
use crate::primitives::watertight::edge_function;

/// A polygon of fewer than three vertices: how many it has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TooFewVertices(pub usize);

/// A polygon's plane and where its vertices are.
#[derive(Debug, Clone, Copy)]
pub struct Polygon<S: Scalar> {
    /// Unit normal (Newell), zero for a polygon without area.
    pub normal: Vec3<S>,
    /// A point of the plane.
    anchor: Vec3<S>,
    first: u32,
    count: u32,
    bounds: Aabb<S>,
}

impl<S: Scalar> Polygon<S> {
    /// Appends the vertices to `store` and returns the polygon over them.
    ///
    /// # Errors
    /// `TooFewVertices` below three vertices.
    pub fn new(vertices: &[glam::DVec3], store: &mut Vec<[S; 3]>) -> Result<Self, TooFewVertices> {
        if vertices.len() < 3 {
            return Err(TooFewVertices(vertices.len()));
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
        Ok(Self {
            normal: Vec3::<S>::from_dvec3(normal),
            anchor: Vec3::<S>::from_dvec3(vertices[0]),
            first,
            count: vertices.len() as u32,
            bounds,
        })
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
        let denominator = self.normal.dot(ray.direction);
        let t = self.normal.dot(self.anchor - ray.origin) / denominator;
        // also refuses NaN (0/0: the ray lies in the plane) and infinities
        if !(t >= ray.t_min && t <= t_max && t.is_finite()) {
            return None;
        }
        let any;
        let shear = if shear.is_too_small() {
            any = Shear::of_any(ray, shear.fine);
            &any
        } else {
            shear
        };
        encloses_axis(self.outline(store), shear).then_some(t)
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

    /// See [`crate::primitives::PrimSet::hull`]: balls as large as the vertices are off the plane.
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
    let Some(last) = outline.last() else { return false };
    let mut inside = false;
    let mut p = shear.apply(last);
    for v in outline {
        let q = shear.apply(v);
        if (p[1] > S::ZERO) != (q[1] > S::ZERO) {
            // the edge crosses the x axis; is the crossing at x > 0?
            let side = edge_function(p[0], q[1], q[0], p[1]);
            if (side > S::ZERO) == (q[1] > p[1]) {
                inside = !inside;
            }
        }
        p = q;
    }
    inside
}

/// The unit normal by Newell's method (sum of cross products); zero when there is no area.
pub fn newell_normal(vertices: &[glam::DVec3]) -> glam::DVec3 {
    let mut normal = glam::DVec3::ZERO;
    let Some(&origin) = vertices.first() else { return normal };
    for (i, &p) in vertices.iter().enumerate() {
        let q = vertices[(i + 1) % vertices.len()];
        normal += (p - origin).cross(q - origin);
    }
    normal.normalize_or_zero()
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::dvec3;

    fn hits(vertices: &[DVec3], x: f64, y: f64) -> bool {
        let mut store = Vec::new();
        let p = Polygon::<f32>::new(vertices, &mut store).unwrap();
        let ray = Ray::<f32>::new(glam::vec3(x as f32, y as f32, 2.0), -glam::Vec3::Z);
        p.intersect(&store, &ray, &Shear::of(&ray, 2.0), f32::INFINITY).is_some()
    }

    #[test]
    fn concave_outline() {
        // HARD_CASES G12: area 0.4, which a fan would take for 3.6
        let v = [
            dvec3(0.0, 0.0, 0.0),
            dvec3(2.0, 0.0, 0.0),
            dvec3(0.2, 0.2, 0.0),
            dvec3(0.0, 2.0, 0.0),
        ];
        let n = 200;
        let inside = (0..n * n)
            .filter(|i| {
                hits(
                    &v,
                    2.0 * (f64::from(i % n) + 0.5) / 200.0,
                    2.0 * (f64::from(i / n) + 0.5) / 200.0,
                )
            })
            .count();
        let area = 4.0 * inside as f64 / f64::from(n * n);
        // exact area by the shoelace formula: 0.4
        assert!((area - 0.4).abs() < 0.02, "{area}");
    }

    #[test]
    fn neighbours_share_their_edge_without_gap_or_overlap() {
        let a = [
            dvec3(0.0, 0.0, 0.0),
            dvec3(1.0, 0.1, 0.0),
            dvec3(1.1, 0.9, 0.0),
            dvec3(0.0, 1.0, 0.0),
        ];
        let b = [
            dvec3(1.0, 0.1, 0.0),
            dvec3(2.0, 0.0, 0.0),
            dvec3(2.0, 1.0, 0.0),
            dvec3(1.1, 0.9, 0.0),
        ];
        for i in 1..1000 {
            let s = f64::from(i) / 1000.0 * 0.8;
            let (x, y) = (1.0 + 0.125 * s, 0.1 + s);
            assert!(hits(&a, x, y) != hits(&b, x, y), "at {x} {y}");
        }
    }

    #[test]
    fn degenerate_outlines() {
        assert!(matches!(
            Polygon::<f32>::new(&[DVec3::ZERO, DVec3::X], &mut Vec::new()),
            Err(TooFewVertices(2))
        ));
        let flat = [dvec3(0.0, 0.0, 0.0), dvec3(1.0, 0.0, 0.0), dvec3(2.0, 0.0, 0.0)];
        assert!(!hits(&flat, 0.5, 0.0));
    }
}
