//! Rays at the corners and edges within a mesh, where no right test may find a hole.
//!
//! A ray aims at an edge that two triangles share, or at a corner that a ring of triangles
//! surrounds. Exact predicates (crate `robust`) say, as seen from the ray's origin, that the two
//! lie on different sides of the edge, and each neighbours of the ring on different sides of the
//! spoke they share. Where the outline of the two, or of the ring, is farther from the ray than
//! rounding can move anything, the ray passes through one of them at least, however its direction
//! was rounded, and a test that hits none has a hole.

use std::collections::HashMap;

use accel_core::primitives::PrimsRef;
use accel_core::query::tracer::Tracer;
use accel_core::registry::Buildable;
use accel_core::{Hit, Ray, Scalar};
use glam::{DVec3, Vec3};
use robust::{Coord3D, orient3d};
use statistics::random::Random;

use crate::accuracy::axis::*;
use crate::verify::among_triangles::exact;
use crate::verify::draw::{point, unit};
use exact_geometry::triangles::Soup;

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

/// A hit by so much later than the target, of the target's parameter, lies behind it.
const BEHIND: f64 = 1e-3;
/// A target must be so deep within its triangle, in barycentric coordinates.
const DEEP: f64 = 0.01;
/// A ray begins so many epsilons of the largest coordinate before its target, at least: nearer, its
/// own rounding decides on which side.
const NEAREST: f64 = 512.0;

/// A ray, and the parameter by which it must have hit something.
#[derive(Debug, Clone, Copy)]
pub struct KnownHit {
    pub ray: Ray<f32>,
    /// A later hit lies behind what is there.
    pub latest: f64,
}

impl KnownHit {
    pub fn is_wrong<S: Scalar>(&self, hit: &Hit<S>) -> bool {
        !hit.is_hit() || hit.t.to_f64() > self.latest
    }
}

/// Judges the answers to such rays.
pub fn judged<S: Buildable>(
    tracer: &dyn Tracer<S>,
    known: &[KnownHit],
    rays: &[Ray<S>],
) -> TrialCounts {
    let mut hits = vec![Hit::NONE; rays.len()];
    tracer.closest_hits(rays, &mut hits);
    let mut counts = TrialCounts::default();
    known.iter().zip(&hits).for_each(|(known, hit)| counts.add(known.is_wrong(hit)));
    counts
}

/// The triangles of the scene with their ids.
pub(super) fn triangles(prims: PrimsRef<'_, f32>) -> Vec<(u32, Corners)> {
    let set = prims.primitives();
    let corners = |id| Some((id, set.corners(id)?.map(|p| p.to_array())));
    (0..set.len() as u32).filter_map(corners).collect()
}

/// Rays at corners and edges, and rays along axes and from close by; `most` of each at most.
pub fn known_hits(stage: &Stage<'_>, most: usize) -> [Vec<KnownHit>; 2] {
    let triangles = triangles(stage.prepared.geometry.prims());
    let corners = || triangles.iter().flat_map(|(_, t)| t).map(|p| glam::Vec3::from(*p));
    let low = corners().fold(glam::Vec3::INFINITY, glam::Vec3::min);
    let high = corners().fold(glam::Vec3::NEG_INFINITY, glam::Vec3::max);
    let (centre, reach) = ((low + high) * 0.5, (high - low).length());
    let shared = SharedFeatures::new(&triangles);
    let mut random = stage.random("edges");
    let drawn = (0..most * 8).filter_map(|_| shared.aim(&mut random, centre, reach));
    // the direction goes from the origin to the target
    let at_edges = drawn.map(|aim| KnownHit { ray: aim.ray, latest: 1.0 + BEHIND }).take(most);
    let at_edges = at_edges.collect();
    let magnitude = f64::from(low.abs().max(high.abs()).max_element());
    let nearest = NEAREST * f64::from(f32::EPSILON) * magnitude;
    let mut random = stage.random("middles");
    let drawn = (0..most * 4).filter_map(|_| {
        let (_, t) = triangles.get(random.below(triangles.len()))?;
        let t = t.map(|p| glam::Vec3::from(p).as_dvec3());
        let normal = (t[1] - t[0]).cross(t[2] - t[0]);
        let k = (0..3).max_by(|&a, &b| normal[a].abs().total_cmp(&normal[b].abs()))?;
        let sign = if random.below(2) == 0 { 1.0 } else { -1.0 };
        let away = nearest * (f64::from(reach) / nearest).max(2.0).powf(unit(&mut random));
        middle(t, k, sign, away, nearest)
    });
    [at_edges, drawn.take(most).collect()]
}

/// A ray along axis `k` at the middle of a triangle, from that far away.
fn middle(t: [DVec3; 3], k: usize, sign: f64, away: f64, nearest: f64) -> Option<KnownHit> {
    let mut from = (t[0] + t[1] + t[2]) / 3.0;
    from[k] += sign * away;
    let mut direction = glam::Vec3::splat(-0.0);
    direction[k] = -sign as f32;
    let ray = Ray::<f32>::new(from.as_vec3(), direction);
    let met = exact(&ray)?.meetings(&Soup::new(&[t]), 0.0, 0.0);
    let met = met.first().filter(|met| met.depth > DEEP && met.t > nearest)?;
    let latest = met.t * (1.0 + BEHIND) + nearest;
    ray.is_traceable().then_some(KnownHit { ray, latest })
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

    #[test]
    fn rays_at_triangle_centres_must_hit() {
        let t = [DVec3::ZERO, glam::dvec3(1.0, 0.0, 0.0), glam::dvec3(0.0, 1.0, 0.0)];
        let known = middle(t, 2, 1.0, 0.5, 1e-4).unwrap();
        assert!(known.ray.direction.x.is_sign_negative() && known.ray.direction.x == 0.0);
        assert!(!known.is_wrong(&Hit { t: 0.5_f32, id: 0 }));
        assert!(!known.is_wrong(&Hit { t: 0.2_f32, id: 7 }), "something may stand in front");
        assert!(known.is_wrong(&Hit { t: 0.51_f32, id: 7 }) && known.is_wrong(&Hit::<f32>::NONE));
        // too near to tell, or in the plane of the ray
        assert!(middle(t, 2, 1.0, 1e-5, 1e-4).is_none());
        assert!(middle(t, 0, 1.0, 0.5, 1e-4).is_none());
    }
}
