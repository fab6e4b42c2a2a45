//! The image in tiles, each traced alone.

use rayon::prelude::*;

use super::prepared::BeamScene;
use super::tile::Tile;

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
