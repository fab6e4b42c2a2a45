//! Refraction of beams: cut until a linear map is right enough.
//!
//! Paper: P. Heckbert, P. Hanrahan, SIGGRAPH 1984, section 3.2: refraction bends straight lines,
//! but near a central ray it is nearly linear, and for that ray the map is exact.
//!
//! Deviations: A narrow beam leaves glass as if from two places on its central ray: seen across
//! the plane of incidence at the distance r / e from the surface, within that plane at
//! r c^2 / e, where r is the eye's distance, e = sin(out) / sin(in), c = cos(out) / cos(in) (the
//! sagittal and the tangential focus of an oblique pencil: Coddington's equations). The
//! paper's map takes the first; ours lies between the two, so that rays beside the central one are
//! off alike in all directions: by e |1 - 1/c| of their angle to it. A piece that is too wide for
//! that is halved, so that the error has a bound; so is one that is reflected totally in part.

use glam::{DVec2, DVec3};

use super::convex::{Affine, ConvexPolygon, CutSide};
use super::pyramid::{Plane, Pyramid};
use super::visibility::halving_line;
use crate::surface::refract;

/// Pieces of less area, square pixels, are not halved: they are bent as their central rays.
const SMALLEST: f64 = 1.0 / 64.0;

#[derive(Debug, Clone)]
pub struct BeamPart {
    pub piece: ConvexPolygon,
    pub beam: BendOutcome,
}

/// Result of a beam that meets glass.
#[derive(Debug, Clone)]
pub enum BendOutcome {
    Through(Box<Pyramid>),
    /// It would go along the surface, without a volume.
    Flat,
    Totally,
}

pub struct BendSetup<'a> {
    pub pyramid: &'a Pyramid,
    pub plane: &'a Plane,
    /// Its outer unit normal.
    pub normal: DVec3,
    /// Index of refraction of the inside.
    pub index: f64,
}

impl BendSetup<'_> {
    /// The parts of a piece. Rays of a part are off by at most `most` times the angle that a pixel
    /// spans, but for parts of less than 1/64 of a pixel.
    pub fn parts(&self, piece: &ConvexPolygon, most: f64) -> Vec<BeamPart> {
        let mut parts = Vec::new();
        let mut todo = vec![piece.clone()];
        while let Some(piece) = todo.pop() {
            let (beam, error) = self.whole(&piece);
            let halves = if error > most { halves(&piece) } else { None };
            match halves {
                Some(halves) => todo.extend(halves),
                None => parts.push(BeamPart { piece, beam }),
            }
        }
        parts
    }

    /// The beam behind the surface by the central ray of a piece, and by how much the direction
    /// at its worst corner is off, in angles of a pixel.
    fn whole(&self, piece: &ConvexPolygon) -> (BendOutcome, f64) {
        let centre = piece.centroid();
        let incoming = self.incoming(centre);
        let bent = |p: &DVec2| refract(self.incoming(*p), self.normal, self.index);
        let Some(out) = refract(incoming, self.normal, self.index) else {
            let all = piece.corners().iter().all(|p| bent(p).is_none());
            return (BendOutcome::Totally, if all { 0.0 } else { f64::INFINITY });
        };
        let shear = self.shear(incoming, out);
        let Some(through) = self.pyramid.through(self.plane, shear, out) else {
            return (BendOutcome::Flat, 0.0);
        };
        let next = [DVec2::X, DVec2::Y].map(|step| self.incoming(centre + step));
        let pixel = next.map(|d| (d - incoming).length());
        let error = |p: &DVec2| match bent(p) {
            Some(right) => (through.direction(*p).normalize_or_zero() - right).length(),
            None => f64::INFINITY,
        };
        let worst = piece.corners().iter().map(error).fold(0.0, f64::max);
        (BendOutcome::Through(Box::new(through)), worst / pixel[0].min(pixel[1]))
    }

    /// The map that takes one unit direction to the other ([`Pyramid::through`]).
    fn shear(&self, incoming: DVec3, out: DVec3) -> DVec3 {
        let cos_in = incoming.dot(self.normal);
        // sin(out) / sin(in), by Snell
        let e = if cos_in < 0.0 { 1.0 / self.index } else { self.index };
        let c = (out.dot(self.normal) / cos_in).abs();
        // the foci, as reciprocals in units of the eye's distance, weighed by what errors there do
        let (across, within) = (e, e / (c * c));
        let distance = (1.0 + c) / (across + within * c);
        (out * distance - incoming) / incoming.dot(self.plane.normal)
    }

    fn incoming(&self, p: DVec2) -> DVec3 {
        self.pyramid.direction(p).normalize_or_zero()
    }
}

/// A piece halved, between pixels if it can be; `None` for small ones.
fn halves(piece: &ConvexPolygon) -> Option<[ConvexPolygon; 2]> {
    if piece.area() < SMALLEST {
        return None;
    }
    let middle = || {
        let [low, high] = piece.bounds();
        let size = high - low;
        let axis = if size.x >= size.y { DVec2::X } else { DVec2::Y };
        Affine { slope: axis, offset: -(low + high).dot(axis) * 0.5 }
    };
    match piece.cut(&halving_line(piece).unwrap_or_else(middle)) {
        CutSide::Both(a, b) => Some([a, b]),
        CutSide::Inside | CutSide::Outside => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DMat3;

    /// An eye over water, or below it, that sees (x, y) in the direction (x - 4, y, 8).
    fn parts(normal: DVec3, most: f64) -> Vec<BeamPart> {
        let frame = DMat3::from_cols(DVec3::X, DVec3::Y, DVec3::new(-4.0, 0.0, 8.0));
        let pyramid = Pyramid::new(DVec3::ZERO, frame, 10.0).unwrap();
        let depth = Affine { slope: DVec2::ZERO, offset: 8.0 };
        let plane = Plane { normal, point: DVec3::Z, depth };
        let bend = BendSetup { pyramid: &pyramid, plane: &plane, normal, index: 1.5 };
        bend.parts(&ConvexPolygon::rectangle(DVec2::ZERO, DVec2::splat(8.0)), most)
    }

    #[test]
    fn rays_beside_the_middle_are_off_by_the_stated_part() {
        let frame = DMat3::from_cols(DVec3::X, DVec3::Y, DVec3::new(-1.0, 2.0, 3.0));
        let pyramid = Pyramid::new(DVec3::ZERO, frame, 10.0).unwrap();
        for (turned, index) in [(1.0, 1.5), (-1.0, 1.2), (1.0, 0.9)] {
            let normal = DVec3::new(0.1, -0.3, -1.0).normalize();
            let over = frame.transpose() * normal / normal.dot(DVec3::Z * 2.0);
            let depth = Affine { slope: over.truncate(), offset: over.z };
            let plane = Plane { normal, point: DVec3::Z * 2.0, depth };
            let bend =
                BendSetup { pyramid: &pyramid, plane: &plane, normal: normal * turned, index };
            let middle = DVec2::ZERO;
            let d = bend.incoming(middle);
            let out = refract(d, bend.normal, index).unwrap();
            let inside = pyramid.through(&plane, bend.shear(d, out), out).unwrap();
            assert!((inside.direction(middle).normalize() - out).length() < 1e-14);
            let at = pyramid.point(middle, depth.at(middle));
            assert!((inside.point(middle, depth.at(middle)) - at).length() < 1e-12);
            let cos = |d: DVec3| d.dot(normal).abs();
            let (c, e) = (cos(out) / cos(d), if turned > 0.0 { 1.0 / index } else { index });
            let across = d.cross(normal).normalize();
            for step in [across, across.cross(d)] {
                let p = pyramid.project(d + step * 1e-4);
                let p = p.truncate() / p.z;
                let right = refract(bend.incoming(p), bend.normal, index).unwrap();
                let wrong = (inside.direction(p).normalize() - right).length();
                let stated = e * (1.0 - 1.0 / c).abs() * 1e-4;
                assert!((wrong / stated - 1.0).abs() < 1e-2, "{wrong:e} {stated:e}");
            }
        }
    }

    #[test]
    fn parts_cover_the_beam_and_get_finer_for_smaller_errors() {
        let mut before = 0;
        for most in [10.0, 0.3, 0.1, 0.03] {
            let parts = parts(-DVec3::Z, most);
            assert!((parts.iter().map(|p| p.piece.area()).sum::<f64>() - 64.0).abs() < 1e-9);
            assert!(parts.len() > before, "{most}: {}", parts.len());
            before = parts.len();
        }
    }

    #[test]
    fn total_reflection_begins_where_it_should() {
        // from below, at a tangent of 1 / sqrt(1.5^2 - 1): a circle about (4, 0)
        let parts = parts(DVec3::Z, 0.3);
        let radius = 8.0 / 1.25_f64.sqrt();
        let leaves = |p: DVec2| (p - DVec2::new(4.0, 0.0)).length() < radius;
        let is_through = |part: &BeamPart| matches!(part.beam, BendOutcome::Through(_));
        assert!(parts.iter().all(|part| is_through(part) == leaves(part.piece.centroid())));
        assert!(!parts.iter().all(is_through));
        // only small parts lie across the circle
        let across =
            |part: &&BeamPart| part.piece.corners().iter().any(|p| leaves(*p) != is_through(part));
        let across: Vec<&BeamPart> = parts.iter().filter(across).collect();
        assert!(across.len() > 10 && across.iter().all(|part| part.piece.area() < SMALLEST));
    }
}
