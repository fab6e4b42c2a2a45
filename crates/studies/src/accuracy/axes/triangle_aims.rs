//! Rays at the corners and edges within a mesh, where no right test may find a hole.
//!
//! A ray aims at an edge that two triangles share, or at a corner that a ring of triangles
//! surrounds. Exact predicates (crate `robust`) say, as seen from the ray's origin, that the two
//! lie on different sides of the edge, and each neighbours of the ring on different sides of the
//! spoke they share. Where the outline of the two, or of the ring, is farther from the ray than
//! rounding can move anything, the ray passes through one of them at least, however its direction
//! was rounded, and a test that hits none has a hole.

use std::collections::HashMap;

use accel_core::Ray;
use glam::{DVec3, Vec3};
use robust::{Coord3D, orient3d};

use crate::verify::draw::{point, unit};
use statistics::random::Random;

/// A ray, and the primitives of which it is asked: here the triangles around its target, of which
/// it must hit one.
#[derive(Debug, Clone)]
pub struct AimedRay {
    pub ray: Ray<f32>,
    pub primitives: Vec<u32>,
}

/// Distance of an outline from the ray, in roundings of the largest coordinate.
const ROUNDINGS: f64 = 64.0;

/// Three corners in single precision.
type Corners = [[f32; 3]; 3];

/// Shared edges and corners, by the bits of coordinates.
pub struct SharedFeatures<'a> {
    triangles: &'a [(u32, Corners)],
    edges: HashMap<[[u32; 3]; 2], Vec<u32>>,
    corners: HashMap<[u32; 3], Vec<u32>>,
    /// Corners in the order of their first appearance, so that a seed means the same on any
    /// machine.
    order: Vec<[f32; 3]>,
}

fn bits(p: [f32; 3]) -> [u32; 3] {
    // + 0.0 makes -0.0 and 0.0 the same
    p.map(|x| (x + 0.0).to_bits())
}

fn edge(a: [f32; 3], b: [f32; 3]) -> [[u32; 3]; 2] {
    let mut ends = [bits(a), bits(b)];
    ends.sort_unstable();
    ends
}

impl<'a> SharedFeatures<'a> {
    /// Collects the features of triangles with their ids, except those without area.
    pub fn new(triangles: &'a [(u32, Corners)]) -> Self {
        let (mut edges, mut corners) = (HashMap::new(), HashMap::new());
        let mut order = Vec::new();
        for ((_, t), index) in triangles.iter().zip(0_u32..) {
            let [a, b, c] = t.map(|p| Vec3::from(p).as_dvec3());
            if (b - a).cross(c - a).length_squared() == 0.0 {
                continue;
            }
            for k in 0..3 {
                let around: &mut Vec<u32> = corners.entry(bits(t[k])).or_default();
                if around.is_empty() {
                    order.push(t[k]);
                }
                around.push(index);
                let of_edge: &mut Vec<u32> = edges.entry(edge(t[k], t[(k + 1) % 3])).or_default();
                of_edge.push(index);
            }
        }
        Self { triangles, edges, corners, order }
    }

    fn corners_of(&self, index: u32) -> Corners {
        self.triangles.get(index as usize).map(|(_, corners)| *corners).unwrap_or_default()
    }

    /// The ray at a target, and the ids of the triangles around it, unless an edge of them that is
    /// not an inner one comes too near.
    fn aimed(
        &self,
        from: Vec3,
        target: Vec3,
        around: &[u32],
        is_inner: impl Fn([f32; 3], [f32; 3]) -> bool,
    ) -> Option<AimedRay> {
        let ray = Ray::<f32>::new(from, target - from);
        let reach = from.abs().max(target.abs()).max(ray.direction.abs()).max_element();
        let margin = f64::from(reach * f32::EPSILON) * ROUNDINGS;
        let edges = around.iter().flat_map(|index| {
            let [a, b, c] = self.corners_of(*index);
            [(a, b), (b, c), (c, a)]
        });
        let mut outline = edges.filter(|(p, q)| !is_inner(*p, *q));
        if outline.any(|(p, q)| passes_at(&ray, p, q) < margin) {
            return None;
        }
        let id = |index: &u32| self.triangles.get(*index as usize).map(|(id, _)| *id);
        let primitives = around.iter().filter_map(id).collect();
        ray.is_traceable().then_some(AimedRay { ray, primitives })
    }

    /// The corner of a triangle that is none of the two.
    fn third(&self, id: u32, a: [f32; 3], b: [f32; 3]) -> Option<[f32; 3]> {
        let other = |p: &[f32; 3]| bits(*p) != bits(a) && bits(*p) != bits(b);
        self.corners_of(id).into_iter().find(other)
    }

    /// The two triangles at an edge, where they lie on different sides of it as seen from `eye`.
    fn both_sides(&self, eye: DVec3, a: [f32; 3], b: [f32; 3]) -> Option<[u32; 2]> {
        let &[first, second] = self.edges.get(&edge(a, b))?.as_slice() else { return None };
        let side = |id| {
            let wide = |p: [f32; 3]| coord(Vec3::from(p).as_dvec3());
            Some(orient3d(coord(eye), wide(a), wide(b), wide(self.third(id, a, b)?)))
        };
        (side(first)? * side(second)? < 0.0).then_some([first, second])
    }

    /// The ring around a corner, where it surrounds it as seen from `eye`.
    fn ring(&self, eye: DVec3, corner: [f32; 3]) -> Option<Vec<u32>> {
        let ring = self.corners.get(&bits(corner))?;
        let mut spokes = 0;
        for &id in ring {
            for end in self.corners_of(id).into_iter().filter(|p| bits(*p) != bits(corner)) {
                self.both_sides(eye, corner, end)?;
                spokes += 1;
            }
        }
        (spokes == 2 * ring.len() && ring.len() >= 3).then(|| ring.clone())
    }

    /// A ray at a corner or, every other time, at an edge; none where what was drawn has an open or
    /// outer side.
    pub fn aim(&self, random: &mut Random, centre: Vec3, reach: f32) -> Option<AimedRay> {
        let corner = *self.order.get(random.below(self.order.len()))?;
        let from = centre + point(random).as_vec3() * (reach * 1.5);
        let eye = from.as_dvec3();
        if random.below(2) == 0 {
            let around = self.ring(eye, corner)?;
            let is_inner = |p, q| bits(p) == bits(corner) || bits(q) == bits(corner);
            return self.aimed(from, Vec3::from(corner), &around, is_inner);
        }
        let around = self.corners.get(&bits(corner))?;
        let id = *around.get(random.below(around.len()))?;
        let end = self.corners_of(id).into_iter().find(|p| bits(*p) != bits(corner))?;
        let around = self.both_sides(eye, corner, end)?;
        // clear of the ends, where other triangles begin
        let part = 0.1 + 0.8 * unit(random) as f32;
        let target = Vec3::from(corner).lerp(Vec3::from(end), part);
        self.aimed(from, target, &around, |p, q| edge(p, q) == edge(corner, end))
    }
}

/// How near the line of a ray comes to an edge, seen along the ray.
fn passes_at(ray: &Ray<f32>, a: [f32; 3], b: [f32; 3]) -> f64 {
    let Some(along) = ray.direction.as_dvec3().try_normalize() else { return 0.0 };
    let seen = |p: [f32; 3]| {
        let from = Vec3::from(p).as_dvec3() - ray.origin.as_dvec3();
        from - along * from.dot(along)
    };
    let (a, b) = (seen(a), seen(b));
    let part = -a.dot(b - a) / (b - a).length_squared().max(f64::MIN_POSITIVE);
    (a + (b - a) * part.clamp(0.0, 1.0)).length()
}

fn coord(p: DVec3) -> Coord3D<f64> {
    Coord3D { x: p.x, y: p.y, z: p.z }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::verify::meshes::icosphere;

    #[test]
    fn outlines_are_never_aimed_at() {
        let ball = icosphere(2, DVec3::ZERO);
        let corners: Vec<Corners> =
            ball.iter().map(|t| t.map(|p| p.as_vec3().to_array())).collect();
        let with_ids: Vec<_> = (0..).zip(corners.clone()).collect();
        let shared = SharedFeatures::new(&with_ids);
        let mut random = Random::new(1, "aims");
        let aims: Vec<AimedRay> =
            (0..4000).filter_map(|_| shared.aim(&mut random, Vec3::ZERO, 2.0)).collect();
        assert!(aims.len() > 1000, "{}", aims.len());
        for aim in aims {
            assert!(aim.primitives.len() == 2 || (5..=6).contains(&aim.primitives.len()));
            let sides = aim.primitives.iter().map(|&id| {
                let [a, b, c] = corners[id as usize].map(Vec3::from);
                // outwards, whichever way round the corners are
                let normal = (b - a).cross(c - a);
                normal.dot(a) * normal.dot(aim.ray.origin - a) > 0.0
            });
            let sides: Vec<bool> = sides.collect();
            assert!(sides.iter().all(|s| *s == sides[0]), "an outline: {aim:?}");
        }
    }

    #[test]
    fn open_edges_are_left_out() {
        let alone = [(0, [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])];
        let shared = SharedFeatures::new(&alone);
        let mut random = Random::new(1, "aims");
        assert!((0..100).all(|_| shared.aim(&mut random, Vec3::ZERO, 2.0).is_none()));
    }
}
