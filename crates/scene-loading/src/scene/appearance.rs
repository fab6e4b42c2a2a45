//! Materials and lights of a scene.

use glam::DVec3;

/// Linear RGB, nominally in [0, 1].
pub type Rgb = [f64; 3];

/// Surface properties in the terms of NFF's `f` line.
#[derive(Debug, Clone, PartialEq)]
pub struct Material {
    /// Name in the source file, empty where the format has none.
    pub name: String,
    pub color: Rgb,
    pub diffuse: f64,
    /// Specular share Ks: highlights, and mirror reflection when > 0.
    pub specular: f64,
    /// Phong exponent of the highlight.
    pub shine: f64,
    /// Transmitted share T: > 0 spawns refracted rays.
    pub transmittance: f64,
    /// Index of refraction, used when `transmittance` > 0.
    pub refraction_index: f64,
    /// Index into `Scene::textures` of the image that the colour is multiplied with, where
    /// primitives have texture coordinates.
    pub texture: Option<u32>,
    /// Width of the distribution of the microfacets that reflect (alpha of GGX), in [0, 1]; 0 is
    /// a perfect mirror. No loader but that of scene files sets it.
    pub roughness: f64,
}

impl Default for Material {
    /// A grey, fully diffuse, opaque surface.
    fn default() -> Self {
        Self {
            name: String::new(),
            color: [0.7; 3],
            diffuse: 1.0,
            specular: 0.0,
            shine: 0.0,
            transmittance: 0.0,
            refraction_index: 1.0,
            texture: None,
            roughness: 0.0,
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Light {
    /// A point light without falloff, as NFF's `l`.
    Point {
        position: DVec3,
        /// Its colour, or `None` where the file gives none (then every light counts
        /// 1/sqrt(number of lights), as SPD's documentation asks).
        color: Option<Rgb>,
    },
    /// A light without falloff that has an extent: a disc that faces whatever it lights, as a
    /// ball does. Of radius 0 it is a point light.
    Disc {
        position: DVec3,
        /// As for [`Light::Point`].
        color: Option<Rgb>,
        /// Radius in world units, >= 0.
        radius: f64,
    },
}

impl Light {
    /// Position of its centre.
    pub fn position(&self) -> DVec3 {
        match *self {
            Self::Point { position, .. } | Self::Disc { position, .. } => position,
        }
    }

    /// Its colour, where the file gives one.
    pub fn color(&self) -> Option<Rgb> {
        match *self {
            Self::Point { color, .. } | Self::Disc { color, .. } => color,
        }
    }

    /// Its radius in world units; 0 for a point.
    pub fn radius(&self) -> f64 {
        match *self {
            Self::Point { .. } => 0.0,
            Self::Disc { radius, .. } => radius,
        }
    }
}
