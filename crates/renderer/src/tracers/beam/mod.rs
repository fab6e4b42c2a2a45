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
mod counts;
mod faces;
mod outline;
mod pixels;
mod prepared;
mod pyramid;
mod refusal;
mod settings;
mod tile;
mod tiling;
mod visibility;

use accel_core::query::region::FrustumWork;
use scene_loading::Scene;

pub use refusal::refusal;
pub use settings::{INFO, Settings};
pub use tile::CoveredArea;
pub use tiling::coverage;

use super::info::{DrawnImage, Frame, Refusal, Structures};
use crate::film::Image;
use counts::Counts;
use prepared::BeamScene;

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
    Ok(DrawnImage { image: Image { width, height, pixels }, work, counts: counts.named() })
}
