//! Settings of cone tracing.

use crate::tracers::info::TracerInfo;

pub static INFO: TracerInfo = TracerInfo {
    name: "cone",
    summary: "one cone per pixel: covered areas instead of samples, also for soft shadows",
    paper: "Amanatides 1984",
    assumptions: "a pixel is a disc; a surface is shaded at the middle of its visible part; \
                  cones stay round; shares of outlines that still overlap are estimated",
    deviations: "exact areas; cut into four where the estimate fails; oblique reflection; sides of \
                 truncated cones",
    refuses: "motion, a lens, rough mirrors",
};

/// How cones are traced.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// How often a cone is cut into four where its estimate fails; 0 is the paper's plain estimate.
    pub subdivisions: u32,
    /// A cone is cut where the normal turns by more than this across its footprint, radians.
    pub turn: f64,
    /// Radius of a pixel's cone over that of a disc with the pixel's area; 0 traces rays.
    pub width: f64,
    /// True if curved surfaces change the spread of a cone. Without, reflections are wrong: it
    /// shows what that is worth.
    pub widening: bool,
    /// Cones that contribute less than this part of a pixel go on as rays; those from surfaces
    /// within one cone as one ray.
    pub ray_below: f64,
}

impl Default for Settings {
    fn default() -> Self {
        Self { subdivisions: 2, turn: 0.5, width: 1.0, widening: true, ray_below: 1.0 / 64.0 }
    }
}
