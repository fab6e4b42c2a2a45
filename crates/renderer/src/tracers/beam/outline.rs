//! A face as a beam sees it: the lines that bound it in the image, and its depth.
//!
//! Paper: P. Heckbert, P. Hanrahan, SIGGRAPH 1984. Deviation: nothing is divided by depth: a line
//! is the cross product of the homogeneous points it joins, so that a face may reach far out of
//! the image or close to the eye, and faces that share an edge share its line bit by bit.

use glam::{DVec2, DVec3};

use super::convex::{Affine, ConvexPolygon, ON, edges};
use super::faces::Face;
use super::pyramid::Pyramid;

/// A face seen at an angle of less than this sine is seen edge-on: it covers nothing.
const EDGE_ON: f64 = 1e-13;

/// Area of the image covered by a convex face.
#[derive(Debug, Clone)]
pub struct Outline {
    pub id: u32,
    /// Its edges, inside to the positive side.
    pub lines: Vec<Affine>,
    /// 1/s of its plane.
    pub depth: Affine,
    /// Its corners (s u, s v, s), all with s > 0.
    corners: Vec<DVec3>,
}

/// How a face lies on a piece of the image.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Relation {
    /// It has no area in common with it.
    Disjoint,
    /// It may cover a part of it.
    Partial,
    Covers,
}

impl Outline {
    /// Outline of a face; `None` if the pyramid behind the rectangle of the image from `low` to
    /// `high` cannot meet it.
    pub fn of(face: &Face, pyramid: &Pyramid, [low, high]: [DVec2; 2]) -> Option<Self> {
        if pyramid.is_beside(&face.corners, low, high) {
            return None;
        }
        let kept = pyramid.keep(&face.corners);
        let corners: Vec<DVec3> = kept.iter().map(|&x| pyramid.project(x)).collect();
        let &first = corners.first()?;
        let normal: DVec3 =
            corners.windows(2).map(|pair| (pair[0] - first).cross(pair[1] - first)).sum();
        let centre = corners.iter().sum::<DVec3>() / corners.len() as f64;
        let height = normal.dot(centre);
        if height.is_nan() || height.abs() <= EDGE_ON * normal.length() * centre.length() {
            return None;
        }
        let side = height.signum();
        let line = |(a, b): (DVec3, DVec3)| {
            let across = a.cross(b) * side;
            Affine { slope: across.truncate(), offset: across.z }.as_line()
        };
        let lines: Vec<Affine> = edges(&corners).filter_map(line).collect();
        let depth = normal / height;
        let depth = Affine { slope: depth.truncate(), offset: depth.z };
        (lines.len() >= 3).then_some(Self { id: face.id, lines, depth, corners })
    }

    /// How it lies on a piece.
    pub fn relation(&self, piece: &ConvexPolygon) -> Relation {
        let mut covers = true;
        for line in &self.lines {
            let [inside, outside] = piece.sides(line);
            if !inside {
                return Relation::Disjoint;
            }
            covers &= !outside;
        }
        if covers {
            return Relation::Covers;
        }
        if self.is_beside(piece) { Relation::Disjoint } else { Relation::Partial }
    }

    /// True when an edge of the piece has all of this outline beyond it.
    fn is_beside(&self, piece: &ConvexPolygon) -> bool {
        let centroid = piece.centroid();
        edges(piece.corners()).any(|(a, b)| {
            let slope = (b - a).perp();
            let edge = Affine { slope, offset: -slope.dot(a) };
            let Some(line) = edge.as_line() else { return false };
            let side = if line.at(centroid) < 0.0 { -1.0 } else { 1.0 };
            self.corners
                .iter()
                .all(|c| side * (line.slope.dot(c.truncate()) + line.offset * c.z) <= ON * c.z)
        })
    }
}
