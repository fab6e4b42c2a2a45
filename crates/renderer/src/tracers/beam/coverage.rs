//! Visible area of each surface in every pixel: the exact answer that samples estimate.

use scene_loading::Scene;

use super::prepared::BeamScene;
use super::settings::Settings;
use super::tile::{CoveredArea, Tile};
use crate::tracers::drawing::{Frame, Structures};
use crate::tracers::info::Refusal;

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
