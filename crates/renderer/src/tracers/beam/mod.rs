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
//! frustum may meet; those are projected to the image as convex outlines, and a piece of the image
//! is cut along their lines (`visibility.rs`). Only flat faces stay flat under projection and
//! mirroring: all else is refused.
//!
//! Deviations from the paper: no beam tree is kept; beams are not stored in a coordinate system of
//! their own but all in that of the image; faces need no order of depth, so that they may overlap
//! in cycles and go through each other; candidates come from a structure.

mod bend;
mod convex;
mod faces;
mod outline;
mod pyramid;
mod scene;
mod tile;
mod visibility;

use accel_core::query::region::FrustumWork;
use rayon::prelude::*;
use scene_loading::Scene;

pub use scene::{INFO, Settings, refusal};
pub use tile::CoveredArea;

use super::info::{DrawnImage, Frame, Refusal, Structures};
use crate::film::Image;
use scene::{BeamScene, Counts};
use tile::Tile;

/// Draws the scene by beams, in the current rayon pool. The same image for any number of threads.
///
/// # Errors
/// [`Refusal`] for what beams cannot do.
pub fn draw(
    scene: &Scene,
    frame: Frame,
    settings: &Settings,
    over: Structures<'_>,
) -> Result<DrawnImage, Refusal> {
    let prepared = BeamScene::new(scene, frame, settings, over)?;
    let tiles = prepared.tiles(false);
    let (mut work, mut counts) = (FrustumWork::default(), Counts::default());
    for tile in &tiles {
        work += tile.work;
        counts += tile.counts;
    }
    let pixels = prepared.assemble([0.0; 3], &tiles, |tile| &tile.colors);
    let [width, height] = frame.resolution;
    Ok(DrawnImage { image: Image { width, height, pixels }, work, counts: counts.rows() })
}

/// Surfaces seen by the pixels of an image, row by row: one line per depth and primitive, in that
/// order. The exact answer that samples estimate.
///
/// # Errors
/// [`Refusal`], as [`draw`].
pub fn coverage(
    scene: &Scene,
    frame: Frame,
    settings: &Settings,
    over: Structures<'_>,
) -> Result<Vec<Vec<CoveredArea>>, Refusal> {
    let prepared = BeamScene::new(scene, frame, settings, over)?;
    let tiles = prepared.tiles(true);
    let mut pixels = prepared.assemble(Vec::new(), &tiles, Tile::covered);
    for pixel in &mut pixels {
        pixel.sort_by_key(|c: &CoveredArea| (c.depth, c.id));
        pixel.dedup_by(|more, sum| {
            let same = (more.depth, more.id) == (sum.depth, sum.id);
            if same {
                sum.area += more.area;
                sum.lit += more.lit;
            }
            same
        });
    }
    Ok(pixels)
}

impl BeamScene<'_> {
    /// Traces every tile in the current rayon pool, `recording` what is seen where or not; in
    /// order.
    pub fn tiles(&self, recording: bool) -> Vec<Tile<'_>> {
        let [width, height] = self.frame.resolution;
        let edge = self.settings.tile;
        let corners: Vec<[u32; 2]> = (0..height)
            .step_by(edge as usize)
            .flat_map(|y| (0..width).step_by(edge as usize).map(move |x| [x, y]))
            .collect();
        let trace = |candidates: &mut _, corner: &[u32; 2]| {
            let [x, y] = *corner;
            let size = [edge.min(width - x), edge.min(height - y)];
            let mut tile = Tile::new(self, *corner, size, recording);
            tile.trace(candidates);
            tile
        };
        corners.par_iter().map_init(Default::default, trace).collect()
    }

    /// Places the pixels of tiles into an image.
    pub fn assemble<'t, T: Clone + 't>(
        &self,
        empty: T,
        tiles: &'t [Tile<'t>],
        of: impl Fn(&'t Tile<'t>) -> &'t [T],
    ) -> Vec<T> {
        let [width, height] = self.frame.resolution.map(|n| n as usize);
        let mut pixels = vec![empty; width * height];
        for tile in tiles {
            let rows = of(tile).chunks(tile.size[0].max(1) as usize);
            for (row, y) in rows.zip(tile.corner[1] as usize..) {
                let begin = y * width + tile.corner[0] as usize;
                if let Some(place) = pixels.get_mut(begin..begin + row.len()) {
                    place.clone_from_slice(row);
                }
            }
        }
        pixels
    }
}
