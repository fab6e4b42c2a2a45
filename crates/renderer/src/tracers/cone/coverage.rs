//! How much of a cone a surface covers, and the surface that the cone leaves.

use glam::DVec3;

use super::disc_overlap::Overlap;
use super::outline::Outline;

/// The surface that a cone leaves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DepartedSurface {
    pub id: u32,
    /// Whether the cone goes into the body: against the outer geometric normal.
    pub inwards: bool,
    /// Where the surface is flat, or the cone goes into a ball, what lies behind is not met: a unit
    /// normal on the side of the cone, and how far along it the surface lies.
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
