//! Beam tracing: pyramids instead of rays, cut exactly by the polygons they meet.
//!
//! Paper: P. Heckbert, P. Hanrahan, "Beam Tracing Polygonal Objects", SIGGRAPH 1984.
//!
//! How are rays cut into bundles? The image is cut into tiles, a beam each. A beam is cut along
//! the outlines of what it meets until every part sees one face: the bundles are given by the
//! scene, not chosen. A part that sees a mirror or glass goes on as a new beam, and one that is
//! turned to a light is cut once more, by the outlines of what lies between.
//!
//! How good is the approximation? Visibility, mirror reflection and the shadows of point lights
//! are exact but for rounding: a pixel gets the area of every part, so that edges are antialiased
//! without samples. Approximate are: shading, which is evaluated once for each pixel of each lit
//! part, at its centre; and refraction, which bends straight lines. A refracted beam is the
//! linear map that is right for its central ray (`bend.rs` states the error: for glass met
//! at 45 degrees, 0.13 of the angle to that ray). Beams are halved until no ray is off by
//! more than [`Settings::bend`] of the angle that a pixel spans, or reflected totally in part;
//! parts of less than 1/64 of a pixel are decided by their central ray.
//!
//! How is a bundle intersected with surfaces? A structure names the primitives that the beam's
//! shaft may meet; those are projected to the image as convex outlines, and a piece of the image
//! is cut along their lines (`visibility.rs`). Only flat faces stay flat under projection and
//! mirroring: all else is refused.
//!
//! Deviations from the paper: no beam tree is kept; beams are not stored in a coordinate system of
//! their own but all in that of the image; faces need no order of depth, so that they may overlap
//! in cycles and go through each other; candidates come from a structure.

mod bend;
mod convex;
mod counts;
mod coverage;
mod faces;
mod outline;
mod pixels;
mod pyramid;
mod refusal;
mod tile;
mod visibility;

use accel_core::region::Work;
use glam::DVec3;
use rayon::prelude::*;
use scene_loading::{Rgb, Scene};

pub use coverage::{Covered, coverage};
pub use refusal::refusal;

use crate::camera::{EyeRays, Sampling};
use crate::effects::lights;
use crate::film::Image;
use crate::surface::Surfaces;
use crate::tracers::{Drawn, Frame, Refusal, Structures, TracerInfo};
use counts::Counts;
use faces::Faces;
use tile::Tile;

/// Registry line.
pub static INFO: TracerInfo = TracerInfo {
    name: "beam",
    summary: "pyramids cut exactly by the polygons they meet: antialiasing without samples",
    paper: "Heckbert, Hanrahan 1984",
    assumptions: "flat polygons whose outlines do not cross themselves; shading is even over a \
                  pixel's part of a face; refraction bends a ray wrong by up to \
                  a tenth of a pixel's angle",
    deviations: "beams stay in image coordinates; no beam tree, no order of depth: cycles and \
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

/// A scene made ready for beams.
struct Prepared<'a> {
    scene: &'a Scene,
    over: Structures<'a>,
    settings: Settings,
    frame: Frame,
    eye: EyeRays,
    faces: Faces,
    surfaces: Surfaces<'a>,
    lights: Vec<(DVec3, Rgb)>,
    /// Largest coordinate, world units.
    magnitude: f64,
}

impl<'a> Prepared<'a> {
    fn new(
        scene: &'a Scene,
        frame: Frame,
        settings: &Settings,
        over: Structures<'a>,
    ) -> Result<Self, Refusal> {
        refusal(scene)?;
        let bounds = scene.bounds();
        let eye = scene.camera.from.abs().max_element();
        let magnitude = if bounds.is_empty() {
            eye.max(1.0)
        } else {
            bounds.min.abs().max(bounds.max.abs()).max_element().max(eye)
        };
        Ok(Self {
            scene,
            over,
            settings: Settings { tile: settings.tile.max(1), ..*settings },
            frame,
            eye: EyeRays::new(&scene.camera, frame.resolution, Sampling::PixelCentres),
            faces: Faces::of(scene),
            surfaces: Surfaces::new(scene, false),
            lights: lights(scene),
            magnitude,
        })
    }

    /// Traces every tile in the current rayon pool, `recording` what is seen where or not; in
    /// order.
    fn tiles(&self, recording: bool) -> Vec<Tile<'_>> {
        let [width, height] = self.frame.resolution;
        let edge = self.settings.tile;
        let corners: Vec<[u32; 2]> = (0..height)
            .step_by(edge as usize)
            .flat_map(|y| (0..width).step_by(edge as usize).map(move |x| [x, y]))
            .collect();
        let trace = |gathered: &mut _, corner: &[u32; 2]| {
            let [x, y] = *corner;
            let size = [edge.min(width - x), edge.min(height - y)];
            let mut tile = Tile::new(self, *corner, size, recording);
            tile.trace(gathered);
            tile
        };
        corners.par_iter().map_init(Default::default, trace).collect()
    }

    /// Places the pixels of tiles into an image.
    fn assemble<'t, T: Clone + 't>(
        &self,
        empty: T,
        tiles: &'t [Tile<'t>],
        of: impl Fn(&'t Tile<'t>) -> &'t [T],
    ) -> Vec<T> {
        let [width, height] = self.frame.resolution.map(|n| n as usize);
        let mut pixels = vec![empty; width * height];
        for tile in tiles {
            let rows = of(tile).chunks(tile.size()[0].max(1) as usize);
            for (row, y) in rows.zip(tile.corner()[1] as usize..) {
                let begin = y * width + tile.corner()[0] as usize;
                if let Some(place) = pixels.get_mut(begin..begin + row.len()) {
                    place.clone_from_slice(row);
                }
            }
        }
        pixels
    }
}

/// Draws the scene by beams, in the current rayon pool. The same image for any number of threads.
///
/// # Errors
/// [`Refusal`] for what beams cannot do.
pub fn draw(
    scene: &Scene,
    frame: Frame,
    settings: &Settings,
    over: Structures<'_>,
) -> Result<Drawn, Refusal> {
    let prepared = Prepared::new(scene, frame, settings, over)?;
    let tiles = prepared.tiles(false);
    let (mut work, mut counts) = (Work::default(), Counts::default());
    for tile in &tiles {
        work += tile.work();
        counts += tile.counts();
    }
    let pixels = prepared.assemble([0.0; 3], &tiles, Tile::colors);
    let [width, height] = frame.resolution;
    Ok(Drawn { image: Image { width, height, pixels }, work, counts: counts.named() })
}
