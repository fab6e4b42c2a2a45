//! Filling beforehand: every opaque primitive is projected onto the faces of every light's cube.
//!
//! In parallel, by runs of primitives and of cells whose length does not depend on the number of
//! threads, so that neither do the cells.

use glam::DVec3;
use rayon::prelude::*;

use crate::geometry::scalar::Scalar;
use crate::occluders::light_buffer::batches::{BATCH, Batch, FaceCells};
use crate::occluders::light_buffer::bodies::{Bodies, FaceView};
use crate::occluders::light_buffer::direction_cube::{FACES, in_frame};
use crate::occluders::light_buffer::face_tree::{Cells, DIVIDED, END, Face, LONG};
use crate::occluders::light_buffer::facing::FacingPlane;
use crate::occluders::light_buffer::filling::{Limits, fill_face};
use crate::occluders::light_buffer::footprint::{ProjectedBody, Projection};
use crate::occluders::light_buffer::margins::Margins;
use crate::primitives::Ball;

/// The six faces around a light.
pub(super) fn faces<S: Scalar>(
    bodies: &Bodies,
    light: DVec3,
    limits: Limits,
    margins: &Margins,
    out: &mut Cells<S>,
) -> [Face<S>; FACES] {
    let mut shown: [FaceCells; FACES] = std::array::from_fn(|_| FaceCells::default());
    let batches: Vec<[Batch; FACES]> = (0..bodies.bodies.len().div_ceil(BATCH))
        .into_par_iter()
        .map(|i| batches(bodies, light, i * BATCH, margins))
        .collect();
    for six in batches {
        shown.iter_mut().zip(six).for_each(|(all, batch)| all.push(batch));
    }
    let mut face = 0;
    shown.map(|shown| {
        let sight = FaceView { bodies, light, face };
        face += 1;
        fill_face(&shown, &sight, limits, margins, out)
    })
}

/// Footprints of [`BATCH`] bodies on all faces.
fn batches(bodies: &Bodies, light: DVec3, first: usize, margins: &Margins) -> [Batch; FACES] {
    let mut out: [Batch; FACES] = std::array::from_fn(|_| Batch::default());
    let (mut seen, mut normals) = (ProjectedBody::default(), Vec::new());
    let run = bodies.bodies.iter().enumerate().skip(first).take(BATCH);
    for (i, body) in run {
        let own = bodies.own(i);
        let extent = Extent::of(own, light);
        for (face, batch) in out.iter_mut().enumerate() {
            if !extent.may_show(face) {
                continue;
            }
            seen.balls.clear();
            let sight = FaceView { bodies, light, face };
            seen.balls.extend(own.iter().map(|b| sight.local(b)));
            seen.is_outline = body.is_outline;
            let mut projection =
                Projection { margins, sides: &mut batch.sides, normals: &mut normals };
            let Some(mut footprint) = projection.of(body.id, &seen) else { continue };
            footprint.body = i as u32;
            if let Some(plane) = FacingPlane::of(&seen, margins, &mut batch.edges) {
                footprint.plane = Some(batch.planes.len() as u32);
                batch.planes.push(plane);
            }
            batch.footprints.push(footprint);
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

/// Largest index that must fit into a cell's word.
pub(super) fn largest_index<S>(cells: &Cells<S>) -> u128 {
    cells.cells.len().max(cells.records.len()) as u128
}

/// The most that fits.
pub(super) const INDEX_LIMIT: u128 = DIVIDED as u128;
/// The most primitives; higher numbers mean something else in lists.
pub(super) const ID_LIMIT: u128 = LONG as u128;
const _: () = assert!(LONG < END);
