//! Share of a cone covered by a surface, and the surface that the cone leaves.

use glam::DVec3;

use super::disc_overlap::Overlap;
use super::outline::Outline;

/// The surface that a cone leaves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DepartedSurface {
    pub id: u32,
    /// True if the cone goes into the body: against the outer geometric normal.
    pub inwards: bool,
    /// For a flat surface, or a cone into a ball, surfaces behind are not met: unit normal on the
    /// side of the cone, and the position of the surface along it.
    pub plane: Option<(DVec3, f64)>,
}

/// A surface as a cone sees it.
#[derive(Debug, Clone, PartialEq)]
pub struct Coverage {
    /// Share of the cone that it covers if nothing is in front, and where.
    pub overlap: Overlap,
    pub outline: Outline,
    /// A depth that no point of it within the cone lies beyond.
    pub far: f64,
    /// The estimate may be wrong by much.
    pub doubtful: bool,
}
