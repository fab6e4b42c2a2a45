//! What is seen in every pixel, by area: the exact answer that samples estimate.

use scene_loading::Scene;

use super::tile::Tile;
use super::{Prepared, Settings};
use crate::tracers::{Frame, Refusal, Structures};

/// A primitive, or nothing, that is seen in a part of a pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Covered {
    /// 1 as seen from the eye, 2 behind one mirror or glass, and so on.
    pub depth: u32,
    /// The primitive; `None` where nothing is met.
    pub id: Option<u32>,
    /// The part of the pixel, from 0 to 1. Behind a surface that mirrors and transmits, both count.
    pub area: f64,
    /// The part of it that light reaches, summed over the lights; of nothing, all of it.
    pub lit: f64,
}

/// What the pixels of an image see, row by row: a line for each depth and primitive, in that order.
///
/// # Errors
/// [`Refusal`], as [`super::draw`].
pub fn coverage(
    scene: &Scene,
    frame: Frame,
    settings: &Settings,
    over: Structures<'_>,
) -> Result<Vec<Vec<Covered>>, Refusal> {
    let prepared = Prepared::new(scene, frame, settings, over)?;
    let tiles = prepared.tiles(true);
    let mut pixels = prepared.assemble(Vec::new(), &tiles, Tile::covered);
    for pixel in &mut pixels {
        pixel.sort_by_key(|c: &Covered| (c.depth, c.id));
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
