//! Filling beforehand: every opaque primitive is projected onto the faces of every light's cube.

use glam::DVec3;

use super::direction_cube::{FACES, in_frame};
use super::face_tree::{Cells, DIVIDED, END, Face, Filling, LONG, Limits, Shown};
use super::facing::Facing;
use super::footprint::{Projection, Seen};
use super::margins::Margins;
use crate::primitives::{Ball, PrimSet, PrimitiveKind};
use crate::scalar::Scalar;

/// The opaque primitives of a set as balls; what the cubes of all lights are filled from.
pub(super) struct Bodies {
    /// Primitive, end of its balls, and whether they are an outline.
    bodies: Vec<(u32, u32, bool)>,
    balls: Vec<Ball>,
}

impl Bodies {
    /// Of all opaque primitives, grown by `margin`.
    pub(super) fn of<S: Scalar, P: PrimSet<S>>(prims: &P, margin: f64) -> Self {
        let mut this = Self { bodies: Vec::with_capacity(prims.len()), balls: Vec::new() };
        for id in (0..prims.len() as u32).filter(|&id| prims.is_opaque(id)) {
            prims.hull(id, &mut this.balls);
            let is_flat =
                matches!(prims.kind(id), PrimitiveKind::Triangle | PrimitiveKind::Polygon);
            let is_outline = is_flat && !prims.moves(id);
            this.bodies.push((id, this.balls.len() as u32, is_outline));
        }
        for ball in &mut this.balls {
            ball.radius += margin;
        }
        this
    }

    /// Calls `visit` with each body as seen in the frame of a face from `light`.
    fn each(&self, light: DVec3, face: usize, mut visit: impl FnMut(u32, &Seen)) {
        let mut seen = Seen::default();
        let mut first = 0;
        for &(id, last, is_outline) in &self.bodies {
            let own = &self.balls[first as usize..last as usize];
            let local = |b: &Ball| Ball { center: in_frame(face, b.center - light), ..*b };
            seen.balls.clear();
            seen.balls.extend(own.iter().map(local));
            seen.is_outline = is_outline;
            visit(id, &seen);
            first = last;
        }
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
    let (mut shown, mut normals) = (Shown::default(), Vec::new());
    std::array::from_fn(|face| {
        shown.clear();
        bodies.each(light, face, |id, seen| {
            let mut projection =
                Projection { margins, sides: &mut shown.sides, normals: &mut normals };
            let Some(mut footprint) = projection.of(id, seen) else { return };
            if let Some(plane) = Facing::of(seen, margins) {
                footprint.plane = Some(shown.planes.len() as u32);
                shown.planes.push(plane);
            }
            shown.footprints.push(footprint);
        });
        Filling::face(&shown, limits, margins, out)
    })
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
