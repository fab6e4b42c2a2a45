//! Triangulation of planar polygons by ear clipping (G. H. Meisters, "Polygons Have Ears", 1975).
//!
//! Only vertices whose neighbours have changed are looked at again (J. O'Rourke, "Computational
//! Geometry in C", 1998), and what may be in the way of an ear is found in a k-d tree. Outlines that
//! cross themselves are cut up somehow, as fast. What takes more than [`STEPS_PER_CORNER`] all the
//! same is refused.

use glam::{DVec2, DVec3};

use super::point_tree::PointTree;
use crate::progress;

/// The most vertices of a polygon that is cut up.
pub(crate) const MAX_CORNERS: usize = 4 << 20;

/// How many nodes and vertices a polygon's searches may look at, for each of its vertices.
const STEPS_PER_CORNER: u64 = 1000;

/// Outlines up to this long are searched as a whole for what is best where no vertex is an ear; of
/// longer ones this many vertices are.
const NEAR: usize = 256;

/// Progress is told about this often; smaller polygons tell nothing.
const TOLD_EVERY: usize = 1 << 16;

/// A polygon that is not cut up.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error(
    "a polygon of {corners} corners is too large or too entangled to be cut into triangles (at \
     most {MAX_CORNERS} corners, and {STEPS_PER_CORNER} steps a corner)"
)]
pub struct Entangled {
    /// Vertices of the polygon.
    pub corners: usize,
}

/// Cuts a planar polygon, concave or not, into triangles between its vertices; they keep its
/// orientation and are given as positions in `outline`.
///
/// The areas of the triangles add up to that of a simple polygon. They are `k - 2` for `k` vertices;
/// fewer where vertices repeat, form spikes or are left over in a line, as no triangle without area
/// is made. A polygon without area gives none. Outlines that cross themselves are cut up somehow.
///
/// # Errors
/// [`Entangled`] for more than 4 Mi vertices, and where finding ears takes more than 1,000 steps
/// for each of them.
pub fn triangulate(outline: &[DVec3]) -> Result<Vec<[u32; 3]>, Entangled> {
    check_size(outline)?;
    match project(outline) {
        Some(points) => cut_up(Ring::new(points)),
        None => Ok(Vec::new()),
    }
}

/// [`triangulate`] for an outline that is not flat: as it looks along its area vector. The triangles
/// are always `k - 2`, so that none is missing of the surface; some may have no area.
///
/// # Errors
/// As [`triangulate`].
pub(crate) fn triangulate_bent(outline: &[DVec3], area: DVec3) -> Result<Vec<[u32; 3]>, Entangled> {
    check_size(outline)?;
    let (u, v) = area.normalize_or_zero().any_orthonormal_pair();
    let Some(&origin) = outline.first() else { return Ok(Vec::new()) };
    let flat = |&p: &DVec3| DVec2::new((p - origin).dot(u), (p - origin).dot(v));
    cut_up(Ring { keeps_all: true, ..Ring::new(outline.iter().map(flat).collect()) })
}

fn check_size(outline: &[DVec3]) -> Result<(), Entangled> {
    let corners = outline.len();
    if corners > MAX_CORNERS { Err(Entangled { corners }) } else { Ok(()) }
}

fn cut_up(mut ring: Ring) -> Result<Vec<[u32; 3]>, Entangled> {
    let corners = ring.len;
    if corners > TOLD_EVERY {
        progress::begin(corners);
    }
    let triangles = ring.cut_up(STEPS_PER_CORNER * (corners + NEAR) as u64);
    if corners > TOLD_EVERY {
        progress::end();
    }
    triangles.ok_or(Entangled { corners })
}

/// The outline along its dominant axis, turned so that it runs against the clock; `None` if it has
/// no area.
fn project(outline: &[DVec3]) -> Option<Vec<DVec2>> {
    let origin = *outline.first()?;
    let edges = outline.iter().zip(outline.iter().cycle().skip(1));
    let normal: DVec3 = edges.map(|(&a, &b)| (a - origin).cross(b - origin)).sum();
    let axis = normal.abs().max_position();
    if normal[axis] == 0.0 || normal[axis].is_nan() {
        return None;
    }
    let (mut u, mut v) = ((axis + 1) % 3, (axis + 2) % 3);
    if normal[axis] < 0.0 {
        (u, v) = (v, u);
    }
    Some(outline.iter().map(|&p| DVec2::new(p[u] - origin[u], p[v] - origin[v])).collect())
}

/// What is left of the polygon.
struct Ring {
    points: Vec<DVec2>,
    /// Vertex before and after each.
    neighbours: Vec<[usize; 2]>,
    /// Of each vertex that may be an ear the one before and after that may be; of others
    /// [`NO_EAR`].
    candidates: Vec<[usize; 2]>,
    /// Remaining vertices with a turn to the right or none: only they can be in the way of an ear.
    reflex: PointTree,
    /// Vertices left.
    len: usize,
    /// Vertices left when all were last made candidates.
    renewed_at: usize,
    /// Triangles without area are kept, too.
    keeps_all: bool,
    /// Work done so far.
    steps: u64,
}

/// A vertex that was no ear when its neighbours last changed. Unless the outline crosses itself, it
/// is none still.
const NO_EAR: [usize; 2] = [usize::MAX; 2];

impl Ring {
    fn new(points: Vec<DVec2>) -> Self {
        let len = points.len();
        let neighbours: Vec<[usize; 2]> =
            (0..len).map(|i| [(i + len - 1) % len, (i + 1) % len]).collect();
        let turn = |i: u32| {
            let [before, after] = neighbours[i as usize].map(|i| points[i]);
            orientation(before, points[i as usize], after)
        };
        let reflex = (0..len as u32).filter(|&i| turn(i) <= 0.0).collect();
        let reflex = PointTree::new(&points, reflex);
        let candidates = neighbours.clone();
        let (renewed_at, keeps_all, steps) = (len, false, 0);
        Self { points, neighbours, candidates, reflex, len, renewed_at, keeps_all, steps }
    }

    /// All triangles; `None` if that takes more steps than `budget`.
    fn cut_up(&mut self, budget: u64) -> Option<Vec<[u32; 3]>> {
        let all = self.len;
        let mut triangles = Vec::with_capacity(all.saturating_sub(2));
        let (mut here, mut forced) = (1, false);
        while self.len >= 3 {
            if self.steps > budget {
                return None;
            }
            let is_spike = self.is_spike(here);
            if !forced && !is_spike && !self.is_ear(here) {
                here = match self.reject(here) {
                    Some(next) => next,
                    None if self.renew(here) => self.neighbours[here][1],
                    None => {
                        forced = true;
                        self.least_bad(here)
                    }
                };
                continue;
            }
            forced = false;
            if self.len.is_multiple_of(TOLD_EVERY) {
                progress::at(all - self.len);
            }
            let [before, after] = self.neighbours[here];
            if self.keeps_all || self.turn(here) != 0.0 {
                triangles.push([before, here, after].map(|i| i as u32));
            }
            self.remove(here);
            // After an ear, leaving out one vertex makes fewer slivers than a fan. Where a spike
            // was, there may be another.
            here = if is_spike { before } else { self.candidates[after][1] };
        }
        Some(triangles)
    }

    /// Twice the signed area of the triangle that a vertex makes with its neighbours.
    fn turn(&self, i: usize) -> f64 {
        let [before, after] = self.neighbours[i].map(|i| self.points[i]);
        orientation(before, self.points[i], after)
    }

    /// True when the outline turns back at that vertex or stays there, so that it bounds no area.
    fn is_spike(&self, i: usize) -> bool {
        let [before, after] = self.neighbours[i].map(|j| self.points[j] - self.points[i]);
        self.turn(i) == 0.0 && before.dot(after) >= 0.0
    }

    /// True when the triangle at that vertex is within what is left of the polygon.
    fn is_ear(&mut self, i: usize) -> bool {
        let [before, after] = self.neighbours[i];
        let corners = [before, i, after].map(|i| self.points[i]);
        let [a, b, c] = corners;
        let holds = |r: usize| {
            let p = self.points[r];
            orientation(a, b, p) >= 0.0
                && orientation(b, c, p) >= 0.0
                && orientation(c, a, p) >= 0.0
                && !corners.contains(&p)
        };
        self.steps += 1;
        orientation(a, b, c) > 0.0 && !self.reflex.any_within(corners, &holds, &mut self.steps)
    }

    /// Strikes a vertex off the candidates; returns the next of them, if there is one.
    fn reject(&mut self, i: usize) -> Option<usize> {
        let [before, after] = std::mem::replace(&mut self.candidates[i], NO_EAR);
        if after == i {
            return None;
        }
        self.candidates[before][1] = after;
        self.candidates[after][0] = before;
        Some(after)
    }

    /// Makes all vertices candidates again, if enough are gone since the last time that this costs
    /// little in all.
    fn renew(&mut self, mut here: usize) -> bool {
        let gone = self.renewed_at - self.len;
        if gone == 0 || (self.len > NEAR && gone < self.len / 4) {
            return false;
        }
        self.renewed_at = self.len;
        for _ in 0..self.len {
            self.candidates[here] = self.neighbours[here];
            here = self.neighbours[here][1];
        }
        true
    }

    /// The vertex to drop where none is an ear: that with the smallest triangle, looking around
    /// the ring from the one after `last`. It becomes the only candidate.
    fn least_bad(&mut self, last: usize) -> usize {
        let mut here = self.neighbours[last][1];
        let mut best = here;
        for _ in 0..self.len.min(NEAR) {
            if self.turn(here).abs() < self.turn(best).abs() {
                best = here;
            }
            here = self.neighbours[here][1];
        }
        self.candidates[best] = [best; 2];
        best
    }

    /// Takes a candidate out of the ring; its neighbours become candidates.
    fn remove(&mut self, i: usize) {
        let [before, after] = self.neighbours[i];
        self.neighbours[before][1] = after;
        self.neighbours[after][0] = before;
        self.len -= 1;
        for (neighbour, side) in [(before, 0), (after, 1)] {
            if self.candidates[neighbour] == NO_EAR {
                let beyond = self.candidates[i][side];
                self.candidates[neighbour][side] = beyond;
                self.candidates[neighbour][1 - side] = i;
                self.candidates[beyond][1 - side] = neighbour;
                self.candidates[i][side] = neighbour;
            }
        }
        self.reject(i);
        self.reflex.remove(i);
        for neighbour in [before, after] {
            if self.turn(neighbour) > 0.0 {
                self.reflex.remove(neighbour);
            }
        }
    }
}

/// Positive when the three points turn to the left: twice the triangle's area.
pub(super) fn orientation(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    (b - a).perp_dot(c - a)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use glam::DMat3;

    use super::*;

    /// Vector area: its length is the area, its direction the side from which the outline runs
    /// against the clock.
    fn vector_area(outline: &[DVec3]) -> DVec3 {
        let next = outline.iter().cycle().skip(1);
        outline.iter().zip(next).map(|(a, b)| a.cross(*b) * 0.5).sum()
    }

    /// Cuts the outline up, in several planes and both senses, and checks count and area.
    fn check(flat: &[[f64; 2]], triangles: usize) {
        for turn in 0..5 {
            let turn = DMat3::from_euler(glam::EulerRot::XYZ, 0.0, f64::from(turn), 0.3);
            for reversed in [false, true] {
                let mut outline: Vec<_> = flat
                    .iter()
                    .map(|&[x, y]| turn * DVec3::new(x, y, 0.0) + DVec3::new(3.0, -2.0, 1.0))
                    .collect();
                if reversed {
                    outline.reverse();
                }
                let whole = vector_area(&outline);
                let parts: Vec<_> = triangulate(&outline)
                    .unwrap()
                    .into_iter()
                    .map(|t| vector_area(&t.map(|i| outline[i as usize])))
                    .collect();
                assert_eq!(parts.len(), triangles);
                // The areas' sum is the whole only if none overlaps, as all face the same way.
                let sum: f64 = parts.iter().map(|a| a.length()).sum();
                assert!((sum - whole.length()).abs() <= 1e-12 * sum, "{sum} {whole}");
                // Not below 0, but for slivers between vertices in line up to rounding.
                assert!(parts.iter().all(|a| a.dot(whole) > -1e-12 * sum * sum));
            }
        }
    }

    #[test]
    fn squares_and_arrows() {
        check(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]], 2);
        check(&[[0.0, 0.0], [2.0, 0.0], [0.5, 0.5], [0.0, 2.0]], 2);
        check(&[[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]], 4);
    }

    #[test]
    fn combs_stars_and_spirals() {
        // A comb: teeth that see little of each other.
        let mut comb = vec![[0.0, 0.0], [40.0, 0.0]];
        for i in (0..20).rev() {
            let x = 2.0 * f64::from(i);
            comb.extend([[x + 2.0, 1.0 + x * x / 2000.0], [x + 1.0, 9.0]]);
        }
        comb.push([0.0, 1.0]);
        check(&comb, comb.len() - 2);
        let ray = |i: u32, n: u32, r: f64| {
            let (sin, cos) = (TAU * f64::from(i) / f64::from(n)).sin_cos();
            [r * cos, r * sin]
        };
        let star: Vec<_> =
            (0..101).map(|i| ray(i, 101, 1.0 + f64::from(i * 37 % 29) / 3.0)).collect();
        check(&star, 99);
        let out = (0..60).map(|i| ray(i, 20, 1.0 + f64::from(i) / 10.0));
        let back = (0..60).rev().map(|i| ray(i, 20, 1.05 + f64::from(i) / 10.0));
        let spiral: Vec<_> = out.chain(back).collect();
        check(&spiral, 118);
    }

    #[test]
    fn vertices_on_an_edge_stay() {
        let flat = [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [3.0, 0.0], [3.0, 3.0], [0.0, 3.0]];
        let outline = flat.map(|[x, y]| DVec3::new(x, y, 0.0));
        let triangles = triangulate(&outline).unwrap();
        assert_eq!(triangles.len(), 4);
        let area: f64 =
            triangles.iter().map(|t| vector_area(&t.map(|i| outline[i as usize])).length()).sum();
        assert_eq!(area, 9.0);
    }

    #[test]
    fn degenerate_outlines_end() {
        let p = |x: f64, y: f64| DVec3::new(x, y, 0.0);
        assert!(triangulate(&[]).unwrap().is_empty());
        assert!(triangulate(&[p(0.0, 0.0), p(1.0, 0.0)]).unwrap().is_empty());
        assert!(triangulate(&[p(0.0, 0.0), p(1.0, 0.0), p(2.0, 0.0)]).unwrap().is_empty());
        assert!(triangulate(&[p(f64::NAN, 0.0), p(1.0, 0.0), p(2.0, 1.0)]).unwrap().is_empty());
        // A repeated vertex and a spike cost no triangles.
        let square = [p(0.0, 0.0), p(1.0, 0.0), p(1.0, 0.0), p(1.0, 1.0), p(0.0, 1.0)];
        assert_eq!(triangulate(&square).unwrap().len(), 2);
        let spike = [p(0.0, 0.0), p(1.0, 0.0), p(1.0, 1.0), p(5.0, 1.0), p(1.0, 1.0), p(0.0, 1.0)];
        let area: f64 = triangulate(&spike)
            .unwrap()
            .iter()
            .map(|t| vector_area(&t.map(|i| spike[i as usize])).length())
            .sum();
        assert_eq!(area, 1.0);
        // A lopsided bow tie: crosses itself, but must end.
        let tie = [p(0.0, 0.0), p(2.0, 2.0), p(2.0, 0.0), p(0.0, 1.0)];
        assert!(triangulate(&tie).unwrap().len() <= 2);
    }

    /// Numbers in [0, 1), by a linear congruential generator.
    struct Random(u64);

    impl Random {
        fn next(&mut self) -> f64 {
            self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (self.0 >> 40) as f64 / f64::from(1 << 24)
        }
    }

    #[test]
    fn many_vertices_are_cut_up_in_near_linear_time() {
        let n = 100_000;
        let mut random = Random(3);
        let mut ring = |radius: &mut dyn FnMut(&mut Random) -> f64| {
            let corner = |i: usize| {
                let (sin, cos) = (TAU * i as f64 / n as f64).sin_cos();
                DVec2::new(cos, sin) * radius(&mut random)
            };
            (0..n).map(corner).collect::<Vec<DVec2>>()
        };
        let spiral = (0..n).map(|i| {
            let (j, off) = if i < n / 2 { (i, 0.0) } else { (n - 1 - i, 0.05) };
            let turns = j as f64 / (n / 2) as f64 * 100.0;
            DVec2::from_angle(turns) * (1.0 + turns / 10.0 + off)
        });
        for (name, outline, most) in [
            ("circle", ring(&mut |_| 1.0), 5),
            ("coast", ring(&mut |random| 1.0 + 1e-4 * random.next()), 300),
            ("star", ring(&mut |random| 0.5 + 0.5 * random.next()), STEPS_PER_CORNER),
            ("spiral", spiral.collect(), STEPS_PER_CORNER),
        ] {
            let cross = |[a, b, c]: [DVec2; 3]| orientation(a, b, c);
            let mut outline = outline;
            let origin = DVec2::splat(0.0);
            let area = |outline: &[DVec2]| {
                let next = outline.iter().cycle().skip(1);
                outline.iter().zip(next).map(|(&a, &b)| cross([origin, a, b])).sum::<f64>()
            };
            if area(&outline) < 0.0 {
                outline.reverse();
            }
            let mut ring = Ring::new(outline.clone());
            let triangles = ring.cut_up(u64::MAX).unwrap();
            assert_eq!(triangles.len(), n - 2, "{name}");
            let per_corner = ring.steps / n as u64;
            assert!(per_corner < most, "{name}: {per_corner} steps a corner");
            // The sum is the whole only if no triangle overlaps another.
            let parts = triangles.iter().map(|t| cross(t.map(|i| outline[i as usize])).abs());
            let (sum, whole) = (parts.sum::<f64>(), area(&outline));
            assert!((sum - whole).abs() < 1e-9 * sum, "{name}: {sum} {whole}");
            // The planted fault: with a budget it ends early, and says so.
            assert!(Ring::new(outline).cut_up(ring.steps / 2).is_none(), "{name}");
        }
    }

    #[test]
    fn a_bent_outline_has_no_hole() {
        // Seen along any axis two of its corners are one; along its area vector they are not.
        let outline = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 0, 1]]
            .map(|p: [i32; 3]| DVec3::from_array(p.map(f64::from)));
        let triangles = triangulate_bent(&outline, vector_area(&outline)).unwrap();
        assert_eq!(triangles, [[0, 1, 2], [2, 3, 0]]);
        // The planted fault: taken for a flat one it loses half of itself.
        assert_eq!(triangulate(&outline).unwrap().len(), 1);
        // A corner twice costs nothing: its triangle is there, without area.
        let twice = [outline[0], outline[1], outline[1], outline[2], outline[3]];
        assert_eq!(triangulate_bent(&twice, vector_area(&twice)).unwrap().len(), 3);
    }
}
