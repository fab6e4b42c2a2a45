//! Filling beforehand: every opaque primitive is projected onto the faces of every light's cube.
//!
//! In parallel, by runs of primitives and of cells whose length does not depend on the number of
//! threads, so that neither do the cells.

use glam::DVec3;
use rayon::prelude::*;

use super::direction_cube::{FACES, in_frame};
use super::face_tree::{Cells, DIVIDED, END, Face, LONG};
use super::facing::Facing;
use super::filling::{Limits, fill_face};
use super::footprint::{Projection, Seen};
use super::margins::Margins;
use super::sheets::{SHEET, Sheet, Shown};
use crate::primitives::{Ball, PrimSet, PrimitiveKind};
use crate::scalar::Scalar;

/// A primitive.
#[derive(Debug, Clone, Copy)]
struct Body {
    id: u32,
    /// The end of its balls.
    last: u32,
    is_outline: bool,
}

/// The opaque primitives of a set as balls; what the cubes of all lights are filled from.
pub(super) struct Bodies {
    bodies: Vec<Body>,
    balls: Vec<Ball>,
    /// All are triangles that share edges without a gap.
    are_tight: bool,
}

impl Bodies {
    /// Of all opaque primitives, grown by `margin`.
    pub(super) fn of<S: Scalar, P: PrimSet<S>>(prims: &P, margin: f64) -> Self {
        let are_tight = prims.is_watertight();
        let mut this =
            Self { bodies: Vec::with_capacity(prims.len()), balls: Vec::new(), are_tight };
        for id in (0..prims.len() as u32).filter(|&id| prims.is_opaque(id)) {
            prims.hull(id, &mut this.balls);
            let is_flat =
                matches!(prims.kind(id), PrimitiveKind::Triangle | PrimitiveKind::Polygon);
            let is_outline = is_flat && !prims.moves(id);
            this.bodies.push(Body { id, last: this.balls.len() as u32, is_outline });
        }
        for ball in &mut this.balls {
            ball.radius += margin;
        }
        this
    }

    fn own(&self, body: usize) -> &[Ball] {
        let first = body.checked_sub(1).map_or(0, |before| self.bodies[before].last);
        &self.balls[first as usize..self.bodies[body].last as usize]
    }
}

/// All bodies, as seen in the frame of a face.
pub(super) struct Sight<'a> {
    bodies: &'a Bodies,
    light: DVec3,
    face: usize,
}

impl Sight<'_> {
    fn local(&self, ball: &Ball) -> Ball {
        Ball { center: in_frame(self.face, ball.center - self.light), ..*ball }
    }

    /// Whether bodies that share edges leave no gap there.
    pub(super) fn is_tight(&self) -> bool {
        self.bodies.are_tight
    }

    /// The corners of a triangle, in world space and in the frame of the face.
    pub(super) fn triangle(&self, body: u32) -> Option<([DVec3; 3], [Ball; 3])> {
        let balls: &[Ball; 3] = self.bodies.own(body as usize).try_into().ok()?;
        Some((balls.map(|b| b.center), balls.each_ref().map(|b| self.local(b))))
    }
}

/// The six faces around a light.
pub(super) fn faces<S: Scalar>(
    bodies: &Bodies,
    light: DVec3,
    limits: Limits,
    margins: &Margins,
    out: &mut Cells<S>,
) -> [Face<S>; FACES] {
    let mut shown: [Shown; FACES] = std::array::from_fn(|_| Shown::default());
    let sheets: Vec<[Sheet; FACES]> = (0..bodies.bodies.len().div_ceil(SHEET))
        .into_par_iter()
        .map(|i| sheets(bodies, light, i * SHEET, margins))
        .collect();
    for six in sheets {
        shown.iter_mut().zip(six).for_each(|(all, sheet)| all.push(sheet));
    }
    let mut face = 0;
    shown.map(|shown| {
        let sight = Sight { bodies, light, face };
        face += 1;
        fill_face(&shown, &sight, limits, margins, out)
    })
}

/// What the faces show of [`SHEET`] bodies.
fn sheets(bodies: &Bodies, light: DVec3, first: usize, margins: &Margins) -> [Sheet; FACES] {
    let mut out: [Sheet; FACES] = std::array::from_fn(|_| Sheet::default());
    let (mut seen, mut normals) = (Seen::default(), Vec::new());
    let run = bodies.bodies.iter().enumerate().skip(first).take(SHEET);
    for (i, body) in run {
        let own = bodies.own(i);
        let extent = Extent::of(own, light);
        for (face, sheet) in out.iter_mut().enumerate() {
            if !extent.may_show(face) {
                continue;
            }
            seen.balls.clear();
            let sight = Sight { bodies, light, face };
            seen.balls.extend(own.iter().map(|b| sight.local(b)));
            seen.is_outline = body.is_outline;
            let mut projection =
                Projection { margins, sides: &mut sheet.sides, normals: &mut normals };
            let Some(mut footprint) = projection.of(body.id, &seen) else { continue };
            footprint.body = i as u32;
            if let Some(plane) = Facing::of(&seen, margins, &mut sheet.edges) {
                footprint.plane = Some(sheet.planes.len() as u32);
                sheet.planes.push(plane);
            }
            sheet.footprints.push(footprint);
        }
    }
    out
}

/// Bounds of a body around the light: most faces are told from these not to show it.
struct Extent {
    low: DVec3,
    high: DVec3,
}

impl Extent {
    fn of(balls: &[Ball], light: DVec3) -> Self {
        let mut this = Self { low: DVec3::INFINITY, high: DVec3::NEG_INFINITY };
        for ball in balls {
            let center = ball.center - light;
            // what is beyond a side of the pyramid is so by a radius times the root of 2
            this.low = this.low.min(center - ball.radius);
            this.high = this.high.max(center + ball.radius);
        }
        this
    }

    /// False only for a face that shows nothing of it.
    fn may_show(&self, face: usize) -> bool {
        let (a, b) = (in_frame(face, self.low), in_frame(face, self.high));
        let (low, high) = (a.min(b), a.max(b));
        high.z >= 0.0
            && low.x <= high.z
            && low.y <= high.z
            && -high.x <= high.z
            && -high.y <= high.z
    }
}

/// What must fit in a cell's word.
pub(super) fn largest_index<S>(cells: &Cells<S>) -> u128 {
    cells.cells.len().max(cells.records.len()) as u128
}

/// The most that fits.
pub(super) const INDEX_LIMIT: u128 = DIVIDED as u128;
/// The most primitives; higher numbers mean something else in lists.
pub(super) const ID_LIMIT: u128 = LONG as u128;
const _: () = assert!(LONG < END);
