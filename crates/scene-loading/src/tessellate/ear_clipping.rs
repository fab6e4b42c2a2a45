//! Triangulation of planar polygons by ear clipping (G. H. Meisters, "Polygons Have Ears", 1975).

use glam::{DVec2, DVec3};

/// Cuts a planar polygon, concave or not, into triangles between its vertices; they keep its
/// orientation and are given as positions in `outline`.
///
/// The areas of the triangles add up to that of a simple polygon. They are `k - 2` for `k` vertices;
/// fewer where vertices repeat, form spikes or are left over in a line, as no triangle without area
/// is made. A polygon without area gives none. Outlines that cross themselves are cut up somehow.
/// Time grows with the number of vertices times the number of reflex ones.
pub fn triangulate(outline: &[DVec3]) -> Vec<[u32; 3]> {
    let Some(points) = project(outline) else { return Vec::new() };
    let mut triangles = Vec::with_capacity(points.len().saturating_sub(2));
    let mut ring = Ring::new(points);
    let mut here = 1;
    let mut rejected = 0;
    while ring.len >= 3 {
        let is_spike = ring.is_spike(here);
        if !is_spike && !ring.is_ear(here) {
            rejected += 1;
            here = ring.neighbours[here][1];
            if rejected < ring.len {
                continue;
            }
            here = ring.least_bad(here);
        }
        rejected = 0;
        let [before, after] = ring.neighbours[here];
        if ring.turn(here) != 0.0 {
            triangles.push([before, here, after].map(|i| i as u32));
        }
        ring.remove(here);
        // After an ear, leaving out one vertex makes fewer slivers than a fan. Where a spike was,
        // there may be another.
        here = if is_spike { before } else { ring.neighbours[after][1] };
    }
    triangles
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
    /// Remaining vertices with a turn to the right or none: only they can be in the way of an ear.
    reflex: Vec<usize>,
    /// Vertices left.
    len: usize,
}

impl Ring {
    fn new(points: Vec<DVec2>) -> Self {
        let len = points.len();
        let neighbours = (0..len).map(|i| [(i + len - 1) % len, (i + 1) % len]).collect();
        let mut ring = Self { points, neighbours, reflex: Vec::new(), len };
        ring.reflex = (0..len).filter(|&i| ring.turn(i) <= 0.0).collect();
        ring
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
    fn is_ear(&self, i: usize) -> bool {
        let [before, after] = self.neighbours[i];
        let [a, b, c] = [before, i, after].map(|i| self.points[i]);
        let holds = |p: DVec2| {
            orientation(a, b, p) >= 0.0
                && orientation(b, c, p) >= 0.0
                && orientation(c, a, p) >= 0.0
                && ![a, b, c].contains(&p)
        };
        orientation(a, b, c) > 0.0 && !self.reflex.iter().any(|&r| holds(self.points[r]))
    }

    /// The vertex to drop where none is an ear: that with the smallest triangle, looking around
    /// the ring from `start`.
    fn least_bad(&self, start: usize) -> usize {
        let (mut best, mut here) = (start, start);
        for _ in 0..self.len {
            if self.turn(here).abs() < self.turn(best).abs() {
                best = here;
            }
            here = self.neighbours[here][1];
        }
        best
    }

    fn remove(&mut self, i: usize) {
        let [before, after] = self.neighbours[i];
        self.neighbours[before][1] = after;
        self.neighbours[after][0] = before;
        self.len -= 1;
        let mut reflex = std::mem::take(&mut self.reflex);
        reflex.retain(|&r| r != i && !([before, after].contains(&r) && self.turn(r) > 0.0));
        self.reflex = reflex;
    }
}

/// Positive when the three points turn to the left: twice the triangle's area.
fn orientation(a: DVec2, b: DVec2, c: DVec2) -> f64 {
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
        let triangles = triangulate(&outline);
        assert_eq!(triangles.len(), 4);
        let area: f64 =
            triangles.iter().map(|t| vector_area(&t.map(|i| outline[i as usize])).length()).sum();
        assert_eq!(area, 9.0);
    }

    #[test]
    fn degenerate_outlines_end() {
        let p = |x: f64, y: f64| DVec3::new(x, y, 0.0);
        assert!(triangulate(&[]).is_empty());
        assert!(triangulate(&[p(0.0, 0.0), p(1.0, 0.0)]).is_empty());
        assert!(triangulate(&[p(0.0, 0.0), p(1.0, 0.0), p(2.0, 0.0)]).is_empty());
        assert!(triangulate(&[p(f64::NAN, 0.0), p(1.0, 0.0), p(2.0, 1.0)]).is_empty());
        // A repeated vertex and a spike cost no triangles.
        let square = [p(0.0, 0.0), p(1.0, 0.0), p(1.0, 0.0), p(1.0, 1.0), p(0.0, 1.0)];
        assert_eq!(triangulate(&square).len(), 2);
        let spike = [p(0.0, 0.0), p(1.0, 0.0), p(1.0, 1.0), p(5.0, 1.0), p(1.0, 1.0), p(0.0, 1.0)];
        let area: f64 = triangulate(&spike)
            .iter()
            .map(|t| vector_area(&t.map(|i| spike[i as usize])).length())
            .sum();
        assert_eq!(area, 1.0);
        // A lopsided bow tie: crosses itself, but must end.
        let tie = [p(0.0, 0.0), p(2.0, 2.0), p(2.0, 0.0), p(0.0, 1.0)];
        assert!(triangulate(&tie).len() <= 2);
    }
}
