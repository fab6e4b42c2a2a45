//! Footprints of the primitives on a face, in batches made in parallel.

use glam::DVec3;

use crate::occluders::light_buffer::facing::FacingPlane;
use crate::occluders::light_buffer::footprint::{Footprint, HalfPlane};

/// Primitives of a batch, at most.
pub(super) const BATCH: usize = 1 << BATCH_BITS;
const BATCH_BITS: u32 = 12;

/// Footprints of up to [`BATCH`] primitives on a face.
#[derive(Debug, Default)]
pub(super) struct Batch {
    /// One for each primitive that is seen.
    pub(super) footprints: Vec<Footprint>,
    pub(super) sides: Vec<HalfPlane>,
    pub(super) planes: Vec<FacingPlane>,
    /// The planes through the light and the edges of those.
    pub(super) edges: Vec<DVec3>,
}

/// A footprint with what it refers to.
#[derive(Clone, Copy)]
pub(super) struct Print<'a> {
    pub(super) footprint: &'a Footprint,
    batch: &'a Batch,
}

impl<'a> Print<'a> {
    pub(super) fn sides(self) -> &'a [HalfPlane] {
        let own = &self.footprint.sides;
        &self.batch.sides[own.start as usize..own.end as usize]
    }

    pub(super) fn plane(self) -> Option<&'a FacingPlane> {
        self.batch.planes.get(self.footprint.plane? as usize)
    }

    /// The planes of its edges.
    pub(super) fn edges(self, plane: &FacingPlane) -> &'a [DVec3] {
        &self.batch.edges[plane.edges.start as usize..plane.edges.end as usize]
    }
}

/// All that a face shows.
#[derive(Debug, Default)]
pub(super) struct FaceCells {
    batches: Vec<Batch>,
}

impl FaceCells {
    /// Adds the next batch.
    pub(super) fn push(&mut self, batch: Batch) {
        self.batches.push(batch);
    }

    pub(super) fn batches(&self) -> &[Batch] {
        &self.batches
    }

    pub(super) fn footprints(&self) -> impl Iterator<Item = &Footprint> {
        self.batches.iter().flat_map(|s| &s.footprints)
    }

    /// The number by which a footprint of a batch is known.
    pub(super) fn number(batch: usize, footprint: usize) -> u32 {
        (batch as u32) << BATCH_BITS | footprint as u32
    }

    /// The footprint of that number.
    #[inline(always)]
    pub(super) fn print(&self, number: u32) -> Print<'_> {
        let batch = &self.batches[(number >> BATCH_BITS) as usize];
        Print { footprint: &batch.footprints[number as usize & (BATCH - 1)], batch }
    }
}
