//! Triangulation of planar polygons by ear clipping (G. H. Meisters, "Polygons Have Ears", 1975).
//!
//! Only vertices whose neighbours have changed are looked at again (J. O'Rourke, "Computational
//! Geometry in C", 1998), and what may be in the way of an ear is found in a k-d tree. Outlines
//! that cross themselves are cut up somehow, as fast. What takes more than [`STEPS_PER_CORNER`] all
//! the same is refused.

use glam::{DVec2, DVec3};

use crate::polygon::point_tree::{PointTree, orientation};
use crate::progress;

/// The most vertices of a polygon that is cut up.
pub(crate) const MAX_CORNERS: usize = 4 << 20;

/// Limit of nodes and vertices that searches in a polygon visit, per vertex.
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
pub struct SelfCrossing {
    /// Vertices of the polygon.
    pub corners: usize,
}

/// Cuts a planar polygon, concave or not, into triangles between its vertices; they keep its
/// orientation and are given as positions in `outline`.
///
/// The areas of the triangles add up to that of a simple polygon. They are `k - 2` for `k`
/// vertices; fewer where vertices repeat, form spikes or are left over in a line, as no triangle
/// without area is made. A polygon without area gives none. Outlines that cross themselves are cut
/// up somehow.
///
/// # Errors
/// [`SelfCrossing`] for more than 4 Mi vertices, and where finding ears takes more than 1,000 steps
/// for each of them.
pub fn triangulate(outline: &[DVec3]) -> Result<Vec<[u32; 3]>, SelfCrossing> {
    check_size(outline)?;
    project(outline).map_or(Ok(Vec::new()), |points| cut_up(points, false))
}

/// [`triangulate`] for an outline that is not flat: as it looks along its area vector. The
/// triangles are always `k - 2`, so that none is missing of the surface; some may have no area.
///
/// # Errors
/// As [`triangulate`].
pub(crate) fn triangulate_bent(
    outline: &[DVec3],
    area: DVec3,
) -> Result<Vec<[u32; 3]>, SelfCrossing> {
    check_size(outline)?;
    let (u, v) = area.normalize_or_zero().any_orthonormal_pair();
    let Some(&origin) = outline.first() else { return Ok(Vec::new()) };
    let flat = |&p: &DVec3| DVec2::new((p - origin).dot(u), (p - origin).dot(v));
    cut_up(outline.iter().map(flat).collect(), true)
}

/// The triangles of a convex quadrangle, which most polygons are: those that [`Ring`] finds.
fn convex(points: &[DVec2]) -> Option<Vec<[u32; 3]>> {
    let &[a, b, c, d] = points else { return None };
    let turns = [[a, b, c], [b, c, d], [c, d, a], [d, a, b]];
    let is_convex = turns.iter().all(|&[a, b, c]| orientation(a, b, c) > 0.0);
    is_convex.then(|| vec![[0, 1, 2], [2, 3, 0]])
}

fn check_size(outline: &[DVec3]) -> Result<(), SelfCrossing> {
    let corners = outline.len();
    if corners > MAX_CORNERS { Err(SelfCrossing { corners }) } else { Ok(()) }
}

fn cut_up(points: Vec<DVec2>, keeps_all: bool) -> Result<Vec<[u32; 3]>, SelfCrossing> {
    if let Some(triangles) = convex(&points) {
        return Ok(triangles);
    }
    let corners = points.len();
    let mut ring = Ring { keeps_all, ..Ring::new(points) };
    if corners > TOLD_EVERY {
        progress::begin(corners);
    }
    let triangles = ring.cut_up(STEPS_PER_CORNER * (corners + NEAR) as u64);
    if corners > TOLD_EVERY {
        progress::end();
    }
    triangles.ok_or(SelfCrossing { corners })
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

/// Remaining vertices of the polygon.
struct Ring {
    points: Vec<DVec2>,
    /// Vertex before and after each.
    neighbours: Vec<[usize; 2]>,
    /// Neighbours of each candidate in the list of possible ears; [`NO_EAR`] for other vertices.
    candidates: Vec<[usize; 2]>,
    /// Remaining vertices with a turn to the right or none: only they can be in the way of an ear.
    reflex: PointTree,
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

#[cfg(test)]
mod tests;
