//! A scene made ready for beams.

use glam::DVec3;
use scene_loading::{Rgb, Scene};

use super::faces::Faces;
use super::refusal::refusal;
use super::settings::Settings;
use crate::camera::{EyeRays, Sampling};
use crate::effects::lights;
use crate::shading::ray_offset::magnitude;
use crate::shading::surface::Surfaces;
use crate::tracers::info::{Frame, Refusal, Structures};

/// A scene made ready for beams.
pub struct BeamScene<'a> {
    pub scene: &'a Scene,
    pub over: Structures<'a>,
    pub settings: Settings,
    pub frame: Frame,
    pub eye: EyeRays,
    pub faces: Faces,
    pub surfaces: Surfaces<'a>,
    pub lights: Vec<(DVec3, Rgb, f64)>,
    /// Largest coordinate, world units.
    pub magnitude: f64,
}

impl<'a> BeamScene<'a> {
    /// Refuses what beams cannot do.
    ///
    /// # Errors
    /// [`Refusal`] naming what the scene has.
    pub fn new(
        scene: &'a Scene,
        frame: Frame,
        settings: &Settings,
        over: Structures<'a>,
    ) -> Result<Self, Refusal> {
        refusal(scene)?;
        Ok(Self {
            scene,
            over,
            settings: Settings { tile: settings.tile.max(1), ..*settings },
            frame,
            eye: EyeRays::new(&scene.camera, frame.resolution, Sampling::PixelCentres),
            faces: Faces::of(scene),
            surfaces: Surfaces::new(scene, false),
            lights: lights(scene),
            magnitude: magnitude(scene),
        })
    }
}
