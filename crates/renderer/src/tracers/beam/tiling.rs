//! The image in tiles, each traced alone; the visible area of each surface in every pixel, the
//! exact answer that samples estimate.

use rayon::prelude::*;
use scene_loading::Scene;

use super::prepared::BeamScene;
use super::settings::Settings;
use super::tile::{CoveredArea, Tile};
use crate::tracers::info::{Frame, Refusal, Structures};

/// Surfaces seen by the pixels of an image, row by row: one line per depth and primitive, in that
/// order.
///
/// # Errors
/// [`Refusal`], as [`super::draw`].
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
