//! Oracle of polygons, in f64: polygons that a line certainly or possibly meets. It shares no
//! arithmetic with the product's test.
//!
//! Everything is seen along the line: vertices are projected onto the plane across it, where the
//! line is a point. A polygon is met for sure where the even-odd rule says so and no edge is nearer
//! to the point than rounding explains. Near an edge that two polygons share, both seen from the
//! same side, at least one of them is met. So it is at a vertex, since all edges that end there are
//! near.

use std::collections::BTreeMap;

use accel_core::{Hit, Ray, Scalar, Vector};
use glam::{DVec2, DVec3, dvec2};

/// Vertices of polygons, one list each.
pub type Outlines = Vec<Vec<DVec3>>;

/// Epsilons of the distance to the farthest vertex, or of the largest coordinate, by which the
/// product's rounding may move a line sideways.
const SHIFT: f64 = 24.0;

/// Polygons that are wound alike, so that those that share an edge run through it both ways.
#[derive(Debug)]
pub struct Surface {
    faces: Vec<Face>,
    beside: Vec<Vec<u32>>,
    bounds: [DVec3; 2],
}

#[derive(Debug)]
struct Face {
    outline: Vec<DVec3>,
    /// Edge `i` runs from vertex `i`: its number; none where it is there twice and so bounds
    /// nothing.
    edges: Vec<Option<usize>>,
    normal: DVec3,
    centre: DVec3,
    /// How far its vertices are off its plane.
    bend: f64,
    radius: f64,
    /// About its least width: what a bend tilts it over.
    width: f64,
}

/// A polygon that a line meets, or may meet.
#[derive(Debug, Clone, PartialEq)]
struct LineContact {
    id: u32,
    /// Between these the line is in its plane.
    t: [f64; 2],
    /// Edges too near to say more; none where it is met for sure.
    near: Vec<usize>,
    /// True if it is seen from the side that its normal points to; `None` where it is seen edge-on.
    is_front: Option<bool>,
}

impl Surface {
    /// Surface of polygons whose coordinates the product's scalar represents exactly.
    pub fn new(outlines: &[Vec<DVec3>]) -> Self {
        let mut numbers = BTreeMap::new();
        let mut beside: Vec<Vec<u32>> = Vec::new();
        let mut face = |(outline, id): (&Vec<DVec3>, u32)| {
            let mut own = Vec::new();
            for (i, a) in outline.iter().enumerate() {
                let mut ends = [*a, outline[(i + 1) % outline.len()]].map(key);
                ends.sort_unstable();
                let number = *numbers.entry(ends).or_insert(beside.len());
                if number == beside.len() {
                    beside.push(Vec::new());
                }
                own.push(number);
            }
            let times = |number| own.iter().filter(|n| **n == number).count();
            let edges: Vec<Option<usize>> =
                own.iter().map(|&n| (times(n) % 2 == 1).then_some(n)).collect();
            for number in edges.iter().flatten() {
                beside[*number].push(id);
            }
            Face::new(outline, edges)
        };
        let faces = outlines.iter().zip(0..).map(&mut face).collect();
        let empty = [DVec3::INFINITY, DVec3::NEG_INFINITY];
        let vertices = outlines.iter().flatten();
        let bounds = vertices.fold(empty, |[low, high], p| [low.min(*p), high.max(*p)]);
        Self { faces, beside, bounds }
    }

    pub fn magnitude(&self) -> f64 {
        let [low, high] = self.bounds;
        low.abs().max(high.abs()).max_element()
    }

    /// By how much rounding may move a ray from there sideways; far origins are brought near first
    /// (`accel_core::geometry::far_ray`).
    fn shift<S: Scalar>(&self, from: DVec3) -> f64 {
        let [low, high] = self.bounds;
        let far = (from - low).abs().max((from - high).abs()).max_element();
        SHIFT * S::EPSILON.to_f64() * far.min(9.0 * self.magnitude()).max(self.magnitude())
    }

    /// Fault of `hits`, which should be all hits of the polygons, each tested alone, within the
    /// interval of the ray.
    pub fn fault<S: Scalar>(&self, ray: &Ray<S>, hits: &[Hit<S>]) -> Option<String> {
        let met = self.meetings(ray);
        for hit in hits {
            let t = hit.t.to_f64();
            let place = met.iter().find(|m| m.id == hit.id).map(|m| m.t);
            if !place.is_some_and(|[low, high]| low <= t && t <= high) {
                return Some(format!("polygon {} is hit at {t}, not within {place:?}", hit.id));
            }
        }
        let is_hit = |m: &LineContact| hits.iter().any(|hit| hit.id == m.id);
        let [start, end] = [ray.t_min, ray.t_max].map(S::to_f64);
        let is_within = |m: &LineContact| start <= m.t[0] && m.t[1] <= end;
        let lost = |m: &&LineContact| m.near.is_empty() && is_within(m) && !is_hit(m);
        if let Some(m) = met.iter().find(lost) {
            return Some(format!("polygon {} is not hit at {:?}", m.id, m.t));
        }
        self.joined(&met).into_iter().find_map(|group| {
            let all = || group.iter().map(|i| &met[*i]);
            let is_gap = self.is_sealed(&group, &met) && all().all(|m| is_within(m) && !is_hit(m));
            let ids: Vec<u32> = all().map(|m| m.id).collect();
            is_gap.then(|| format!("gap between polygons {ids:?}"))
        })
    }

    /// Polygons whose edges are near, those that are joined by such edges together.
    fn joined(&self, met: &[LineContact]) -> Vec<Vec<usize>> {
        let mut groups: Vec<Vec<usize>> = Vec::new();
        for (i, m) in met.iter().enumerate().filter(|(_, m)| !m.near.is_empty()) {
            let touches = |g: &Vec<usize>| {
                g.iter().any(|&other| met[other].near.iter().any(|e| m.near.contains(e)))
            };
            let (mut joined, apart): (Vec<_>, Vec<_>) = groups.into_iter().partition(touches);
            joined.push(vec![i]);
            groups = apart;
            groups.push(joined.concat());
        }
        groups
    }

    /// Returns whether both sides of each near edge are seen from the same side.
    fn is_sealed(&self, group: &[usize], met: &[LineContact]) -> bool {
        let front = |id: &u32| met.iter().find(|m| m.id == *id).and_then(|m| m.is_front);
        group.iter().flat_map(|i| &met[*i].near).all(|edge| match self.beside[*edge].as_slice() {
            [a, b] => front(a).is_some() && front(a) == front(b),
            _ => false,
        })
    }

    /// All polygons that the line of a ray meets, or may meet.
    fn meetings<S: Scalar>(&self, ray: &Ray<S>) -> Vec<LineContact> {
        let (origin, direction) = (ray.origin.to_dvec3(), ray.direction.to_dvec3());
        let length = direction.length();
        let along = direction / length;
        let shift = self.shift::<S>(origin);
        let x = along.any_orthonormal_vector();
        let y = along.cross(x);
        let across = |p: &DVec3| dvec2((*p - origin).dot(x), (*p - origin).dot(y));
        let meeting = |(id, face): (u32, &Face)| {
            let slack = shift + 4.0 * face.bend;
            if across(&face.centre).length() > face.radius + 2.0 * slack {
                return None;
            }
            let seen: Vec<DVec2> = face.outline.iter().map(across).collect();
            // as projected, an outline has no bend: neighbours must agree which edges are near
            let near = face.place(&seen, shift)?;
            let sine = face.normal.dot(along);
            let middle = face.normal.dot(face.centre - origin) / sine;
            let reach = slack / sine.abs();
            // where a polygon is seen edge-on it is met anywhere in it
            let nearest = (face.centre - origin).dot(along);
            let is_clear = sine.abs() * face.width > 4.0 * slack;
            let t = if is_clear {
                [middle - reach, middle + reach]
            } else {
                [nearest - face.radius - slack, nearest + face.radius + slack]
            };
            let t = [t[0] - shift, t[1] + shift].map(|t| t / length);
            Some(LineContact { id, t, near, is_front: is_clear.then_some(sine < 0.0) })
        };
        (0..).zip(&self.faces).filter_map(meeting).collect()
    }
}

impl Face {
    fn new(outline: &[DVec3], edges: Vec<Option<usize>>) -> Self {
        let centre = outline.iter().sum::<DVec3>() / outline.len() as f64;
        let across = normal(outline, centre);
        let normal = across.normalize_or_zero();
        let off = outline.iter().map(|p| (*p - centre).dot(normal).abs());
        let away = outline.iter().map(|p| p.distance(centre));
        let (bend, radius) = (off.fold(0.0, f64::max), away.fold(0.0, f64::max));
        let width = (across.length() / (4.0 * radius)).min(radius);
        Self { outline: outline.to_vec(), edges, normal, centre, bend, radius, width }
    }

    /// The edges within `slack` of the origin, which is the line; none of them where it runs
    /// through the polygon. `None` where it does not.
    fn place(&self, seen: &[DVec2], slack: f64) -> Option<Vec<usize>> {
        let mut near = Vec::new();
        let mut is_inside = false;
        for (i, edge) in self.edges.iter().enumerate() {
            let Some(edge) = *edge else { continue };
            let (a, b) = (seen[i], seen[(i + 1) % seen.len()]);
            let part =
                (-a.dot(b - a) / (b - a).length_squared().max(f64::MIN_POSITIVE)).clamp(0., 1.);
            if a.lerp(b, part).length() <= slack {
                near.push(edge);
            } else if (a.y > 0.0) != (b.y > 0.0) {
                is_inside ^= (a.perp_dot(b) > 0.0) == (b.y > a.y);
            }
        }
        (is_inside || !near.is_empty()).then_some(near)
    }
}

/// Exact for equal points; zeros of both signs are equal.
fn key(p: DVec3) -> [u64; 3] {
    p.to_array().map(|x| (x + 0.0).to_bits())
}

/// The normal by Newell's method, of twice the area's length; where the parts of a crossing outline
/// cancel, that of the two vertices which span the most.
fn normal(outline: &[DVec3], centre: DVec3) -> DVec3 {
    let at = |i: usize| outline[i % outline.len()] - centre;
    let many = 0..outline.len();
    let newell: DVec3 = many.clone().map(|i| at(i).cross(at(i + 1))).sum();
    let pairs = many.clone().flat_map(|i| many.clone().map(move |k| (i, k)));
    let spans = pairs.map(|(i, k)| at(i).cross(at(k)));
    let widest = spans.fold(DVec3::ZERO, |a, b| if b.length() > a.length() { b } else { a });
    let is_crossed = newell.length() < 1e-6 * widest.length();
    if is_crossed { widest } else { newell }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::verify::round::ray;
    use glam::dvec3;

    fn hit(t: f64, id: u32) -> Hit<f64> {
        Hit { t, id }
    }

    fn square(x: f64, z: f64) -> Vec<DVec3> {
        [(0., 0.), (2., 0.), (2., 2.), (0., 2.)].map(|(u, v)| dvec3(x + u, v, z)).to_vec()
    }

    #[test]
    fn a_lost_a_false_and_a_shifted_hit_are_faults() {
        let surface = Surface::new(&[square(0.0, 0.0), square(0.0, 1.0)]);
        let down: Ray<f64> = ray(dvec3(1.2, 0.7, 3.0), -DVec3::Z);
        let fault = |hits: &[Hit<f64>]| surface.fault(&down, hits).is_some();
        assert!(!fault(&[hit(2.0, 1), hit(3.0, 0)]));
        assert!(fault(&[hit(2.0, 1)]) && fault(&[hit(2.0, 1), hit(3.0 + 1e-10, 0)]));
        let beside: Ray<f64> = ray(dvec3(2.1, 0.7, 3.0), -DVec3::Z);
        assert_eq!(surface.fault(&beside, &[]), None);
        assert!(surface.fault(&beside, &[hit(2.0, 1)]).is_some());
        let short = Ray { t_max: 2.5, ..down };
        assert_eq!(surface.fault(&short, &[hit(2.0, 1)]), None);
    }

    #[test]
    fn a_gap_between_neighbours_is_a_fault_and_the_rim_is_none() {
        let surface = Surface::new(&[square(0.0, 0.0), square(2.0, 0.0)]);
        for (x, is_gap) in [(2.0, true), (0.0, false), (4.0, false)] {
            let down: Ray<f64> = ray(dvec3(x, 0.7, 3.0), -DVec3::Z);
            assert_eq!(surface.fault(&down, &[]).is_some(), is_gap, "{x}");
        }
        let down: Ray<f64> = ray(dvec3(2.0, 0.7, 3.0), -DVec3::Z);
        for ids in [&[0][..], &[1], &[0, 1]] {
            let hits: Vec<_> = ids.iter().map(|id| hit(3.0, *id)).collect();
            assert_eq!(surface.fault(&down, &hits), None);
        }
        // two that meet in a ridge hide each other where they are seen from above and below
        let roof =
            vec![dvec3(2., 0., 0.), dvec3(0., 0., -1.), dvec3(0., 2., -1.), dvec3(2., 2., 0.)];
        let ridge = Surface::new(&[square(0.0, 0.0), roof]);
        let across: Ray<f64> = ray(dvec3(2.0, 0.7, 3.0), dvec3(0.0, 0.1, -1.0));
        assert_eq!(ridge.fault(&across, &[]), None);
    }

    #[test]
    fn bridges_are_inside_and_crossing_outlines_have_a_plane() {
        let bow = [(0., 0.), (2., 2.), (2., 0.), (0., 2.)].map(|(x, y)| dvec3(x, y, 0.0)).to_vec();
        let down = |x, y| -> Ray<f64> { ray(dvec3(x, y, 1.0), -DVec3::Z) };
        let bow = Surface::new(&[bow]);
        assert!(bow.fault(&down(1.7, 1.0), &[]).is_some());
        assert!(bow.fault(&down(1.0, 1.7), &[hit(1.0, 0)]).is_some());
        let hole = [(0., 0.), (4., 0.), (4., 4.), (0., 4.), (0., 0.)];
        let bridge = [(1., 1.), (1., 2.), (2., 2.), (2., 1.), (1., 1.)];
        let ring: Vec<_> = hole.into_iter().chain(bridge).map(|(x, y)| dvec3(x, y, 0.0)).collect();
        let ring = Surface::new(&[ring]);
        assert!(ring.fault(&down(0.5, 0.5), &[]).is_some());
        assert!(ring.fault(&down(1.5, 1.5), &[hit(1.0, 0)]).is_some());
    }
}
