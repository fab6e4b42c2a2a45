//! What a face shows of the primitives, in sheets that were made beside one another.

use glam::DVec3;

use crate::occluders::light_buffer::facing::Facing;
use crate::occluders::light_buffer::footprint::{Footprint, HalfPlane};

/// Primitives of a sheet, at most.
pub(super) const SHEET: usize = 1 << SHEET_BITS;
const SHEET_BITS: u32 = 12;

/// What a face shows of up to [`SHEET`] primitives.
#[derive(Debug, Default)]
pub(super) struct Sheet {
    /// One for each primitive that is seen.
    pub(super) footprints: Vec<Footprint>,
    /// Their half-planes.
    pub(super) sides: Vec<HalfPlane>,
    /// Their planes.
    pub(super) planes: Vec<Facing>,
    /// The planes through the light and the edges of those.
    pub(super) edges: Vec<DVec3>,
}

/// A footprint with what it refers to.
#[derive(Clone, Copy)]
pub(super) struct Print<'a> {
    /// The footprint.
    pub(super) footprint: &'a Footprint,
    sheet: &'a Sheet,
}

impl<'a> Print<'a> {
    /// Its half-planes.
    pub(super) fn sides(self) -> &'a [HalfPlane] {
        let own = &self.footprint.sides;
        &self.sheet.sides[own.start as usize..own.end as usize]
    }

    /// Its plane.
    pub(super) fn plane(self) -> Option<&'a Facing> {
        self.sheet.planes.get(self.footprint.plane? as usize)
    }

    /// The planes of its edges.
    pub(super) fn edges(self, plane: &Facing) -> &'a [DVec3] {
        &self.sheet.edges[plane.edges.start as usize..plane.edges.end as usize]
    }
}

/// All that a face shows.
#[derive(Debug, Default)]
pub(super) struct Shown {
    sheets: Vec<Sheet>,
}

impl Shown {
    /// Adds the next sheet.
    pub(super) fn push(&mut self, sheet: Sheet) {
        self.sheets.push(sheet);
    }

    /// All sheets.
    pub(super) fn sheets(&self) -> &[Sheet] {
        &self.sheets
    }

    /// All footprints.
    pub(super) fn footprints(&self) -> impl Iterator<Item = &Footprint> {
        self.sheets.iter().flat_map(|s| &s.footprints)
    }

    /// The number by which a footprint of a sheet is known.
    pub(super) fn number(sheet: usize, footprint: usize) -> u32 {
        (sheet as u32) << SHEET_BITS | footprint as u32
    }

    /// The footprint of that number.
    #[inline(always)]
    pub(super) fn print(&self, number: u32) -> Print<'_> {
        let sheet = &self.sheets[(number >> SHEET_BITS) as usize];
        Print { footprint: &sheet.footprints[number as usize & (SHEET - 1)], sheet }
    }
}
