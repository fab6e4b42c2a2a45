//! Layers: where triangles that share their edges hide a cell together, though none of them does
//! alone.
//!
//! Paper: none known to us; it is the argument of watertight tests (S. Woop, C. Benthin, I. Wald,
//! JCGT 2(1), 2013) made once a cell. Turn triangles so that all face the light, and let two that
//! have an edge in common (the same corners, bit for bit, in opposite directions) be joined there.
//! How often a set of them winds around a direction changes only where that crosses an edge that
//! is not joined. If no such edge comes near a cell and one triangle holds a direction of it, each
//! direction of the cell meets a triangle of the set. Rounding moves corners by less than the
//! margins and crosses no edge; and the watertight test, whose edge functions have exact signs,
//! then finds a triangle that holds the ray, at a depth between those of its corners. Whatever
//! lies deeper than the whole set is hidden.

use glam::{DVec2, DVec3};

use crate::occluders::light_buffer::margins::Margins;
use crate::primitives::Ball;

/// A triangle as a face shows it.
#[derive(Debug)]
struct Tile {
    /// Corners in world space, by which shared edges are known.
    corners: [DVec3; 3],
    /// The same on the face, turning to the left.
    points: [DVec2; 3],
    far: f64,
    /// By how much rounding may move a point on the face.
    pad: f64,
    /// The tile that stands for those joined with this one, in the end for all of them.
    joined: u32,
    /// Something about it cannot be relied upon.
    is_open: bool,
    /// It holds the direction at the middle of the cell.
    holds_middle: bool,
}

/// An edge that comes near the cell.
#[derive(Debug, Clone, Copy)]
struct Edge {
    /// The same for both directions.
    key: u64,
    tile: u32,
    /// It runs from this corner to the next.
    corner: u8,
}

/// Finds layers; keeps its memory.
#[derive(Debug, Default)]
pub(super) struct Layers {
    tiles: Vec<Tile>,
    edges: Vec<Edge>,
}

/// A number for a pair of corners, in either order.
fn key(a: DVec3, b: DVec3) -> u64 {
    let of = |p: DVec3| {
        // + 0.0 makes -0.0 and 0.0 the same
        (p + 0.0).to_array().iter().fold(0u64, |h, x| {
            (h ^ x.to_bits()).wrapping_mul(0x9e37_79b9_7f4a_7c15).rotate_left(29)
        })
    };
    of(a).wrapping_add(of(b))
}

impl Layers {
    /// The least depth at which a layer ends that hides the cell around `center`, of the triangles
    /// given by their corners in world space and as balls in the frame of the face.
    pub(super) fn hidden_beyond(
        &mut self,
        triangles: impl Iterator<Item = ([DVec3; 3], [Ball; 3])>,
        center: DVec2,
        half: DVec2,
        margins: &Margins,
    ) -> Option<f64> {
        self.tiles.clear();
        self.edges.clear();
        for (corners, balls) in triangles {
            let joined = self.tiles.len() as u32;
            let Some(tile) = Tile::new(corners, balls, joined, center, margins) else { continue };
            for corner in 0..3 {
                if tile.edge_is_near(corner, center, half) {
                    let key = key(tile.corners[corner], tile.corners[(corner + 1) % 3]);
                    self.edges.push(Edge { key, tile: joined, corner: corner as u8 });
                }
            }
            self.tiles.push(tile);
        }
        self.edges.sort_unstable_by_key(|e| (e.key, e.tile, e.corner));
        let mut first = 0;
        while first < self.edges.len() {
            let alike = self.edges[first..].iter().take_while(|e| e.key == self.edges[first].key);
            let last = first + alike.count();
            self.join(first..last);
            first = last;
        }
        self.least_depth()
    }

    /// Joins two tiles along edges that are one; any other number of edges is open.
    fn join(&mut self, edges: std::ops::Range<usize>) {
        if let [a, b] = self.edges[edges.clone()] {
            let ends = |e: Edge| {
                let corners = &self.tiles[e.tile as usize].corners;
                [corners[e.corner as usize], corners[(e.corner as usize + 1) % 3]]
            };
            let ([a0, a1], [b0, b1]) = (ends(a), ends(b));
            if a.tile != b.tile && a0 == b1 && a1 == b0 {
                let (a, b) = (self.stands_for(a.tile), self.stands_for(b.tile));
                self.tiles[a.max(b) as usize].joined = a.min(b);
                return;
            }
        }
        for i in edges {
            let tile = self.edges[i].tile;
            self.tiles[tile as usize].is_open = true;
        }
    }

    fn stands_for(&mut self, mut tile: u32) -> u32 {
        loop {
            let next = self.tiles[tile as usize].joined;
            if next == tile {
                return tile;
            }
            let after = self.tiles[next as usize].joined;
            self.tiles[tile as usize].joined = after;
            tile = after;
        }
    }

    /// Smallest far depth over the closed sets of tiles that contain the middle.
    fn least_depth(&mut self) -> Option<f64> {
        for i in 0..self.tiles.len() as u32 {
            let first = self.stands_for(i) as usize;
            let Tile { far, is_open, holds_middle, .. } = self.tiles[i as usize];
            let all = &mut self.tiles[first];
            all.far = all.far.max(far);
            all.is_open |= is_open;
            all.holds_middle |= holds_middle;
        }
        let is_first = |(i, t): &(usize, &Tile)| t.joined as usize == *i;
        let hides = |t: &&Tile| t.holds_middle && !t.is_open;
        let sets = self.tiles.iter().enumerate().filter(is_first).map(|(_, t)| t);
        sets.filter(hides).map(|t| t.far).min_by(f64::total_cmp)
    }
}

impl Tile {
    /// `None` for a triangle that is too near to the light, or has no area as seen from there.
    fn new(
        mut corners: [DVec3; 3],
        mut balls: [Ball; 3],
        joined: u32,
        middle: DVec2,
        margins: &Margins,
    ) -> Option<Self> {
        let near = balls.iter().map(|b| b.center.z).fold(f64::INFINITY, f64::min);
        let far = balls.iter().map(|b| b.center.z).fold(0.0, f64::max);
        let radius = margins.position;
        if near.is_nan() || near <= radius * 16.0 {
            return None;
        }
        let on_face = |b: &Ball| b.center.truncate() / b.center.z;
        let mut points = [on_face(&balls[0]), on_face(&balls[1]), on_face(&balls[2])];
        let area = (points[1] - points[0]).perp_dot(points[2] - points[0]);
        if area < 0.0 {
            corners.swap(1, 2);
            balls.swap(1, 2);
            points.swap(1, 2);
        }
        if !(area != 0.0 && area.is_finite()) {
            return None;
        }
        // a ball of that radius seen at p is within radius (1 + |p|) / (z - radius) of it
        let slant = points.iter().map(|p| p.length()).fold(1.0, |a, b| a + b);
        let pad = margins.direction * 4.0 + 2.0 * radius * slant / (near - radius);
        let mut tile = Self {
            corners,
            points,
            far: far + radius * 4.0,
            pad,
            joined,
            is_open: false,
            holds_middle: false,
        };
        let sides = [0, 1, 2].map(|i| tile.side(i, middle));
        tile.holds_middle = sides.iter().all(|&s| s > 0);
        // the middle is too near to an edge to say
        tile.is_open = !tile.holds_middle && sides.iter().all(|&s| s >= 0);
        Some(tile)
    }

    /// On which side of an edge a point is: 1 inside, -1 outside, 0 too near to say.
    fn side(&self, corner: usize, point: DVec2) -> i32 {
        let (a, b) = (self.points[corner], self.points[(corner + 1) % 3]);
        let (edge, to) = (b - a, point - a);
        let distance = edge.perp_dot(to);
        let margin = self.pad * (edge.abs().element_sum() + to.abs().element_sum());
        i32::from(distance > margin) - i32::from(distance < -margin)
    }

    /// Returns whether an edge may come into the rectangle, which rounding may move.
    fn edge_is_near(&self, corner: usize, center: DVec2, half: DVec2) -> bool {
        let (a, b) = (self.points[corner] - center, self.points[(corner + 1) % 3] - center);
        let half = half + self.pad;
        let (low, high) = (a.min(b), a.max(b));
        if low.x > half.x || high.x < -half.x || low.y > half.y || high.y < -half.y {
            return false;
        }
        let edge = b - a;
        let reach = edge.x.abs() * half.y + edge.y.abs() * half.x;
        edge.perp_dot(-a).abs() <= reach + self.pad * edge.abs().element_sum()
    }
}
