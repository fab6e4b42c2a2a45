//! The beams of a tile of the image, from the eye on: what they see, what light reaches it, and
//! what they become at mirrors and glass.

use accel_core::query::region::{Candidates, Frustum, FrustumWork};
use glam::{DMat3, DVec2};
use scene_loading::Rgb;

use super::bend::{BeamPart, BendOutcome, BendSetup};
use super::convex::ConvexPolygon;
use super::outline::{Outline, Relation};
use super::pyramid::{Plane, Pyramid};
use super::scene::{BeamScene, Counts};
use super::visibility::{cut_along, resolve};
use crate::effects::{Origin, SurfaceHit, lit_normal, shadow_ray};
use crate::surface::{SurfacePoint, reflect};

/// A frustum reaches so many times the scene's largest coordinate: farther than any two points of
/// the scene are apart.
const REACH: f64 = 4.0;

/// A primitive, or nothing, that is seen in a part of a pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CoveredArea {
    /// 1 as seen from the eye, 2 behind one mirror or glass, and so on.
    pub depth: u32,
    /// The primitive; `None` where nothing is met.
    pub id: Option<u32>,
    /// The part of the pixel, from 0 to 1. Behind a surface that mirrors and transmits, both count.
    pub area: f64,
    /// The part of it that light reaches, summed over the lights; of nothing, all of it.
    pub lit: f64,
}

struct Beam {
    pyramid: Pyramid,
    piece: ConvexPolygon,
    weight: Rgb,
    depth: u32,
    /// The primitive it comes from, which it does not meet again: that is flat, if not to the last
    /// bit.
    from: Option<u32>,
}

/// A part of an image, traced alone: beams never leave the pixels that they started in.
pub struct Tile<'a> {
    on: &'a BeamScene<'a>,
    pub corner: [u32; 2],
    /// Width and height, pixels.
    pub size: [u32; 2],
    /// Its pixels, row by row.
    pub colors: Vec<Rgb>,
    /// If it is recorded.
    covered: Option<Vec<Vec<CoveredArea>>>,
    pub counts: Counts,
    /// Cost of its queries.
    pub work: FrustumWork,
    beams: Vec<Beam>,
}

impl<'a> Tile<'a> {
    /// The pixels from `corner` on, `size` of them across and down.
    pub fn new(on: &'a BeamScene<'a>, corner: [u32; 2], size: [u32; 2], recording: bool) -> Self {
        let pixels = size[0] as usize * size[1] as usize;
        Self {
            on,
            corner,
            size,
            colors: vec![[0.0; 3]; pixels],
            covered: recording.then(|| vec![Vec::new(); pixels]),
            counts: Counts::default(),
            work: FrustumWork::default(),
            beams: Vec::new(),
        }
    }

    /// Areas seen by its pixels, if recorded; not summed up.
    pub fn covered(&self) -> &[Vec<CoveredArea>] {
        self.covered.as_deref().unwrap_or_default()
    }

    pub fn trace(&mut self, candidates: &mut Candidates) {
        candidates.work = FrustumWork::default();
        let [u, v, d] = self.on.eye.frame();
        let [x, y] = self.corner.map(f64::from);
        let frame = DMat3::from_cols(u, v, d + u * x + v * y);
        let size = DVec2::from_array(self.size.map(f64::from));
        let eye = Pyramid::new(self.on.eye.origin(), frame, self.on.magnitude);
        self.counts.beams += 1;
        let piece = ConvexPolygon::rectangle(DVec2::ZERO, size);
        let weight = [1.0; 3];
        self.send(eye.map(|pyramid| Beam { pyramid, piece, weight, depth: 1, from: None }));
        while let Some(beam) = self.beams.pop() {
            self.advance(&beam, candidates);
        }
        self.work = candidates.work;
    }

    /// A beam to be traced, unless it is too deep or has no volume.
    fn send(&mut self, beam: Option<Beam>) {
        match beam {
            Some(beam) if beam.depth > self.on.frame.max_depth => {}
            Some(beam) => self.beams.push(beam),
            None => self.counts.degenerate += 1,
        }
    }

    /// The faces that a frustum may meet, as a pyramid sees them; in the order of their ids.
    fn outlines(
        &self,
        frustum: &Frustum,
        pyramid: &Pyramid,
        piece: &ConvexPolygon,
        candidates: &mut Candidates,
        is_asked: impl Fn(u32) -> bool,
    ) -> Vec<Outline> {
        let bounds = piece.bounds();
        self.on.over.frusta.query(frustum, candidates);
        candidates.ids.sort_unstable();
        let ids = candidates.ids.iter().filter(|&&id| is_asked(id));
        ids.flat_map(|&id| self.on.faces.of_primitive(id))
            .filter_map(|face| Outline::of(face, pyramid, bounds))
            .collect()
    }

    /// Finds what a beam sees, lights it and sends it on.
    fn advance(&mut self, beam: &Beam, candidates: &mut Candidates) {
        let frustum = beam.pyramid.frustum(&beam.piece, REACH * self.on.magnitude);
        let outlines = self
            .outlines(&frustum, &beam.pyramid, &beam.piece, candidates, |id| beam.from != Some(id));
        let piece = beam.piece.clone();
        let fragments = resolve(piece, &outlines, &self.on.settings, &mut self.counts);
        self.counts.fragments += fragments.len() as u64;
        for fragment in fragments {
            match fragment.seen {
                Some(i) => self.light(beam, &fragment.piece, &outlines[i], candidates),
                None => {
                    let background = self.on.scene.background;
                    self.add(beam, &fragment.piece, None, |_| background);
                }
            }
        }
    }

    /// Adds the light of a fragment, and what it mirrors and lets through.
    fn light(
        &mut self,
        beam: &Beam,
        piece: &ConvexPolygon,
        seen: &Outline,
        candidates: &mut Candidates,
    ) {
        let on = self.on;
        let (id, pyramid) = (seen.id, &beam.pyramid);
        let centre = piece.centroid();
        let at = |p: DVec2| -> SurfacePoint<'_> {
            on.surfaces.at(id, pyramid.point(p, seen.depth.at(p)))
        };
        let middle = at(centre);
        let (normal, point) = (middle.refined.normal, middle.refined.position);
        let plane = Plane { normal, point, depth: seen.depth };
        let hit = |p: DVec2| SurfaceHit {
            point: at(p),
            id,
            incoming: pyramid.direction(p).normalize_or_zero(),
            weight: [1.0; 3],
            origin: Origin { column: 0, sample: 0, fanned: false, time: 0.0 },
        };
        self.record(beam, piece, Some(id), 1.0, 0.0);
        for &(light, color, _) in &on.lights {
            let arriving = |p: DVec2| {
                let hit = hit(p);
                shadow_ray(&hit, 0, lit_normal(&hit, true), light, color, 1.0).map(|s| s.light)
            };
            // a flat face is turned to the light in all points alike
            let is_flat = middle.normal.cross(plane.normal).length() < 1e-12;
            if is_flat && arriving(centre).is_none() {
                continue;
            }
            let Some(shadow) = pyramid.shadow(&plane, light) else { continue };
            self.counts.shadows += 1;
            let frustum = pyramid.frustum_to(piece, &plane, light);
            let is_opaque = |other: u32| {
                let primitive = on.scene.primitives.get(other as usize);
                let material = primitive.and_then(|p| on.scene.materials.get(p.material as usize));
                other != id && material.is_some_and(|m| m.transmittance <= 0.0)
            };
            let blockers = self.outlines(&frustum, &shadow, piece, candidates, is_opaque);
            for lit in self.unblocked(piece, &blockers) {
                self.add(beam, &lit, Some(id), |p| arriving(p).unwrap_or_default());
            }
        }
        let m = middle.material;
        if beam.depth >= on.frame.max_depth {
            return;
        }
        if m.specular > 0.0 {
            self.counts.mirrored += 1;
            let towards = reflect(pyramid.direction(centre), middle.normal);
            let mirrored = pyramid.through(&plane, plane.normal * -2.0, towards);
            let weight = beam.weight.map(|w| w * m.specular);
            let (piece, depth, from) = (piece.clone(), beam.depth + 1, Some(id));
            self.send(mirrored.map(|pyramid| Beam { pyramid, piece, weight, depth, from }));
        }
        if m.transmittance > 0.0 {
            self.refract(beam, piece, seen.id, &middle, &plane);
        }
    }

    /// Sends the parts of a fragment through glass.
    fn refract(
        &mut self,
        beam: &Beam,
        piece: &ConvexPolygon,
        id: u32,
        surface: &SurfacePoint<'_>,
        plane: &Plane,
    ) {
        let m = surface.material;
        let weight = beam.weight.map(|w| w * m.transmittance);
        let (normal, index) = (surface.normal, m.refraction_index);
        let bend = BendSetup { pyramid: &beam.pyramid, plane, normal, index };
        for BeamPart { piece, beam: bent } in bend.parts(piece, self.on.settings.bend) {
            match bent {
                BendOutcome::Through(pyramid) => {
                    self.counts.refracted += 1;
                    let (pyramid, depth) = (*pyramid, beam.depth + 1);
                    self.send(Some(Beam { pyramid, piece, weight, depth, from: Some(id) }));
                }
                BendOutcome::Flat => self.counts.degenerate += 1,
                BendOutcome::Totally => self.counts.internal += 1,
            }
        }
    }

    /// The parts of a piece that no outline covers.
    fn unblocked(&mut self, piece: &ConvexPolygon, blockers: &[Outline]) -> Vec<ConvexPolygon> {
        let mut lit = vec![piece.clone()];
        for blocker in blockers {
            let mut next = Vec::with_capacity(lit.len());
            for part in lit {
                match blocker.relation(&part) {
                    Relation::Disjoint => next.push(part),
                    Relation::Covers => {}
                    Relation::Partial => {
                        let (inside, outside) = cut_along(&part, &blocker.lines);
                        let least = self.on.settings.least_area;
                        if inside.is_none_or(|inside| inside.area() <= least) {
                            next.push(part);
                        } else {
                            self.counts.cut += 1;
                            next.extend(outside.into_iter().filter(|o| o.area() > least));
                        }
                    }
                }
            }
            lit = next;
            if lit.is_empty() {
                break;
            }
        }
        lit
    }

    /// Adds light from a piece, once for each pixel of it: `light` at its centre times its area.
    fn add(
        &mut self,
        beam: &Beam,
        piece: &ConvexPolygon,
        id: Option<u32>,
        light: impl Fn(DVec2) -> Rgb,
    ) {
        for part in piece.pixels() {
            let (centre, area) = (part.centroid(), part.area());
            let light = light(centre);
            if let Some(i) = self.index(centre) {
                for (color, (light, weight)) in
                    self.colors[i].iter_mut().zip(light.iter().zip(beam.weight))
                {
                    *color += light * weight * area;
                }
            }
        }
        // nothing is seen at once, what is seen when it is lit
        let share = if id.is_none() { 1.0 } else { 0.0 };
        self.record(beam, piece, id, share, 1.0);
    }

    fn record(&mut self, beam: &Beam, piece: &ConvexPolygon, id: Option<u32>, seen: f64, lit: f64) {
        let Some(mut covered) = self.covered.take() else { return };
        for part in piece.pixels() {
            if let Some(i) = self.index(part.centroid()) {
                let (area, lit) = (part.area() * seen, part.area() * lit);
                covered[i].push(CoveredArea { depth: beam.depth, id, area, lit });
            }
        }
        self.covered = Some(covered);
    }

    /// The pixel that a point lies in.
    fn index(&self, p: DVec2) -> Option<usize> {
        let [width, height] = self.size.map(|n| n as usize);
        let (x, y) = (p.x.floor() as usize, p.y.floor() as usize);
        (x < width && y < height).then_some(y * width + x)
    }
}
