//! Settings of beam tracing.

use crate::tracers::info::TracerInfo;

pub static INFO: TracerInfo = TracerInfo {
    name: "beam",
    summary: "pyramids cut exactly by the polygons they meet: antialiasing without samples",
    paper: "Heckbert, Hanrahan 1984",
    assumptions: "flat polygons with simple outlines; shading is constant over a pixel's part of \
                  a face; refracted directions are off by up to a tenth of a pixel's angle",
    deviations: "beams stay in image coordinates; no beam tree and no depth order: cycles and \
                 intersections are cut; candidates come from a structure",
    refuses: "spheres, cones, lights with a radius, lenses, motion, textures, rough mirrors, \
              mirrors and glass with smooth normals, polygons that cross themselves",
};

/// How beams are cut.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Edge of the tiles that beams start with, pixels, at least 1.
    pub tile: u32,
    /// With more candidates than these, a piece larger than a pixel is halved, not cut by them.
    pub candidates: usize,
    /// By how much a ray may be bent wrong at one refraction, in angles that a pixel spans.
    pub bend: f64,
    /// Pieces with less area, square pixels, are dropped.
    pub least_area: f64,
    /// Pieces of a beam that are cut before all others are decided at their centres.
    pub most_cuts: u64,
}

impl Default for Settings {
    fn default() -> Self {
        Self { tile: 16, candidates: 32, bend: 0.1, least_area: 1e-13, most_cuts: 1_000_000 }
    }
}
