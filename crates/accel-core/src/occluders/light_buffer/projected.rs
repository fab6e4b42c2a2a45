//! Filling beforehand, its first half: every opaque primitive is projected onto the faces of a
//! light's cube (`filling.rs` makes the cells).
//!
//! In parallel, by runs of primitives whose length does not depend on the number of threads, so
//! that neither do the cells.

use glam::DVec3;

use crate::geometry::scalar::Scalar;
use crate::occluders::light_buffer::direction_cube::{FACES, in_frame};
use crate::occluders::light_buffer::facing::FacingPlane;
use crate::occluders::light_buffer::footprint::{Footprint, HalfPlane, ProjectedBody, box_around};
use crate::occluders::light_buffer::margins::Margins;
use crate::parallel;
use crate::primitives::{Ball, PrimitiveKind, Primitives};

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
}

impl Bodies {
    /// Balls around all opaque primitives, grown by `margin`.
    pub(super) fn of<S: Scalar>(prims: &dyn Primitives<S>, margin: f64) -> Self {
        let mut this = Self { bodies: Vec::with_capacity(prims.len()), balls: Vec::new() };
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

/// Primitives of a batch, at most.
const BATCH: usize = 1 << BATCH_BITS;
const BATCH_BITS: u32 = 12;

/// Footprints of up to [`BATCH`] primitives on a face.
#[derive(Debug, Default)]
pub(super) struct Batch {
    /// One for each primitive that is seen.
    pub(super) footprints: Vec<Footprint>,
    sides: Vec<HalfPlane>,
    /// The planes through the light and the edges of outlines.
    edges: Vec<DVec3>,
}

impl Batch {
    /// The half-planes of a footprint.
    pub(super) fn sides_of(&self, own: &Footprint) -> &[HalfPlane] {
        &self.sides[own.sides.start as usize..own.sides.end as usize]
    }

    /// The planes of the edges of a footprint's plane.
    pub(super) fn edges_of(&self, own: &FacingPlane) -> &[DVec3] {
        &self.edges[own.edges.start as usize..own.edges.end as usize]
    }
}

/// All that a face shows.
#[derive(Debug, Default)]
pub(super) struct FaceCells {
    pub(super) batches: Vec<Batch>,
}

impl FaceCells {
    /// What each face around a light shows.
    pub(super) fn around(bodies: &Bodies, light: DVec3, margins: &Margins) -> [Self; FACES] {
        let batches = parallel::map((0..bodies.bodies.len()).step_by(BATCH), &|first| {
            batches(bodies, light, first, margins)
        });
        let mut shown: [Self; FACES] = std::array::from_fn(|_| Self::default());
        for six in batches {
            shown.iter_mut().zip(six).for_each(|(all, batch)| all.batches.push(batch));
        }
        shown
    }

    pub(super) fn footprints(&self) -> impl Iterator<Item = &Footprint> {
        self.batches.iter().flat_map(|s| &s.footprints)
    }

    /// The number by which a footprint of a batch is known.
    pub(super) fn number(batch: usize, footprint: usize) -> u32 {
        (batch as u32) << BATCH_BITS | footprint as u32
    }

    /// The footprint of that number, and its batch.
    #[inline(always)]
    pub(super) fn footprint(&self, number: u32) -> (&Footprint, &Batch) {
        let batch = &self.batches[(number >> BATCH_BITS) as usize];
        (&batch.footprints[number as usize & (BATCH - 1)], batch)
    }
}

/// Footprints of [`BATCH`] bodies on all faces.
fn batches(bodies: &Bodies, light: DVec3, first: usize, margins: &Margins) -> [Batch; FACES] {
    let mut out: [Batch; FACES] = std::array::from_fn(|_| Batch::default());
    let mut seen = ProjectedBody::default();
    let run = bodies.bodies.iter().enumerate().skip(first).take(BATCH);
    for (i, body) in run {
        let own = bodies.own(i);
        let (low, high) = box_around(own.iter().map(|b| Ball { center: b.center - light, ..*b }));
        for (face, batch) in out.iter_mut().enumerate() {
            if !may_show(face, low, high) {
                continue;
            }
            seen.balls.clear();
            let local = |b: &Ball| Ball { center: in_frame(face, b.center - light), ..*b };
            seen.balls.extend(own.iter().map(local));
            seen.is_outline = body.is_outline;
            if let Some(mut footprint) = seen.footprint(body.id, margins, &mut batch.sides) {
                if seen.is_outline {
                    footprint.plane = FacingPlane::of(&seen.balls, margins, &mut batch.edges);
                }
                batch.footprints.push(footprint);
            }
        }
    }
    out
}

/// False only for a face that shows nothing of what lies in this box around the light. What is
/// beyond a side of the face's pyramid is so by a radius times the root of 2.
fn may_show(face: usize, low: DVec3, high: DVec3) -> bool {
    let (a, b) = (in_frame(face, low), in_frame(face, high));
    let (low, high) = (a.min(b), a.max(b));
    high.z >= 0.0 && low.x <= high.z && low.y <= high.z && -high.x <= high.z && -high.y <= high.z
}
