//! Cone tracing: one cone per pixel in place of rays; what it covers is estimated as an area.
//!
//! Paper: J. Amanatides, "Ray Tracing with Cones", SIGGRAPH 1984. Deviations: areas are exact where
//! the paper estimates (`disc_overlap`); estimates that may be wrong are noticed, and the cone is
//! then cut into four; truncated cones and cylinders, which the paper lacks, are covered by their
//! visible outline; oblique reflection (`widening`).
//!
//! The lecture asks three things of a bundle of rays:
//!
//! * *How are rays cut into bundles?* A pixel's cone has the area of the pixel, a disc in place of
//!   a square: neighbours overlap by 9% of their area, and an edge is blurred as by a disc, which
//!   differs from a box by at most 2.5% of coverage. From each surface that is seen, one cone is
//!   mirrored, one refracted, and one goes to each light, as wide as the footprint of what is seen.
//!   A cone is cut into the quarters of its square ([`circular_cone::Cone::quarters`]) where its
//!   estimate fails: outlines overlap or cross ([`compose`]), the normal turns by more than
//!   [`Settings::turn`] across the footprint, or the cone is wide. It happens at most
//!   [`Settings::subdivisions`] times in a path.
//! * *How good is the approximation?* A cone sees one point of each surface, the middle of what is
//!   visible of it: light, colour and texture are those of that point. A reflected cone is round
//!   where the true bundle is elliptic, and not wider than 45 degrees. Where outlines still
//!   overlap, shares are guessed. A shadow's edge is blurred by the footprint and by the disc of
//!   the light as one disc. Cones that contribute less than [`Settings::ray_below`] go on as rays.
//! * *How does a bundle meet surfaces?* Candidates come from the structure, by a pyramid around the
//!   cone, near ones first, until the cone is covered. Each is an outline on the cone's section: a
//!   sphere a disc (`cover_sphere`), a polygon itself (`cover_flat`), the side of a truncated
//!   cone its visible part (`cover_side`). Its share is an area, and shares are added up front to
//!   back ([`compose`]).

mod caster;
pub mod circular_cone;
pub mod compose;
mod cover_flat;
mod cover_side;
mod cover_sphere;
pub mod coverage;
mod disc_overlap;
pub mod forms;
mod fragments;
mod shadows;
mod tracing;
mod widening;

use accel_core::query::region::FrustumWork;
use glam::DVec2;
use rayon::prelude::*;
use scene_loading::{Rgb, Scene};

pub use caster::{INFO, Settings, refusal};

use super::info::{DrawnImage, Frame, Refusal, Structures};
use crate::camera::{EyeRays, Sampling};
use crate::film::Image;
use caster::{Caster, Counts, Scratch};
use circular_cone::Cone;

/// Draws the scene, in the current rayon pool. The same image for any number of threads and any
/// right structure.
///
/// # Errors
/// As [`refusal`].
pub fn draw(
    scene: &Scene,
    frame: Frame,
    settings: &Settings,
    over: Structures<'_>,
) -> Result<DrawnImage, Refusal> {
    refusal(scene)?;
    let [width, height] = frame.resolution;
    let eye = EyeRays::new(&scene.camera, frame.resolution, Sampling::PixelCentres);
    let caster = Caster::new(scene, *settings, frame.max_depth, over);
    let row = |y: u32| {
        let mut scratch = Scratch::default();
        let colors: Vec<Rgb> = (0..width)
            .map(|x| caster.look(pixel_cone(&eye, [x, y], settings.width), &mut scratch))
            .collect();
        (colors, scratch)
    };
    let rows: Vec<(Vec<Rgb>, Scratch)> = (0..height).into_par_iter().map(row).collect();
    let mut pixels = Vec::with_capacity(width as usize * height as usize);
    let (mut work, mut counts) = (FrustumWork::default(), Counts::default());
    for (mut colors, scratch) in rows {
        pixels.append(&mut colors);
        work += scratch.candidates.work;
        counts += scratch.counts;
    }
    let counts = counts.rows();
    Ok(DrawnImage { image: Image { width, height, pixels }, work, counts })
}

/// The cone of a pixel: as large as it, seen from the eye.
fn pixel_cone(eye: &EyeRays, [x, y]: [u32; 2], width: f64) -> Cone {
    let at = |u: f64, v: f64| eye.direction_within(x, y, DVec2::new(u, v));
    let right = at(1.0, 0.5) - at(0.0, 0.5);
    let up = at(0.5, 0.0) - at(0.5, 1.0);
    let radius = (right.cross(up).length() / std::f64::consts::PI).sqrt();
    Cone::new(eye.origin(), eye.direction(x, y), 0.0, radius * width).across(right, up)
}
