//! Looks of a scene: its camera, how finely its effects are sampled, materials, lights, and images
//! that colour surfaces.
//!
//! Texels are the stored values of the image, 8 bits a channel, without alpha. Colours of a scene
//! are not linear-managed (NFF's and MTL's are numbers that the image shows as they are), so
//! texels are taken as such colours too: nothing is decoded from sRGB.

use std::sync::Arc;

use glam::DVec3;
use serde::de::Error;
use serde::{Deserialize, Deserializer};

use crate::error::{FilePlace, LoadError};

/// Linear RGB, nominally in [0, 1].
pub type Rgb = [f64; 3];

/// Phong exponent of a highlight too small to be seen. With 0 a mirror's would be everywhere: a
/// white disc instead of what it reflects.
pub(crate) const NO_HIGHLIGHT: f64 = 100_000.0;

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

/// A light without falloff: a point, or a disc that faces what it lights.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename = "LightEntry", deny_unknown_fields)]
pub struct Light {
    /// Where it is.
    #[serde(deserialize_with = "vector")]
    #[cfg_attr(feature = "schema", schemars(with = "[f64; 3]"))]
    pub position: DVec3,
    /// Its colour; without one it counts 1/sqrt(number of lights), as SPD's documentation asks.
    pub color: Option<Rgb>,
    /// Radius of the disc in world units; 0 is a point.
    #[serde(default, deserialize_with = "at_least_0")]
    #[cfg_attr(feature = "schema", schemars(range(min = 0.0)))]
    pub radius: f64,
}

impl Light {
    /// A light of radius 0, as NFF's `l`.
    pub const fn point(position: DVec3, color: Option<Rgb>) -> Self {
        Self { position, color, radius: 0.0 }
    }
}

/// A number, refused where it is not as `expected` says.
pub(crate) fn checked<'de, D: Deserializer<'de>>(
    from: D,
    is_valid: fn(f64) -> bool,
    expected: &str,
) -> Result<f64, D::Error> {
    let x = f64::deserialize(from)?;
    if is_valid(x) {
        Ok(x)
    } else {
        Err(D::Error::custom(format!("found {x}, expected {expected}")))
    }
}

/// A length or a time.
pub(crate) fn at_least_0<'de, D: Deserializer<'de>>(from: D) -> Result<f64, D::Error> {
    checked(from, |x| x >= 0.0, "a number of at least 0")
}

fn vector<'de, D: Deserializer<'de>>(from: D) -> Result<DVec3, D::Error> {
    <[f64; 3]>::deserialize(from).map(DVec3::from_array)
}

/// An image, rows from the top.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Texture {
    /// File name, or what the source calls it.
    pub name: String,
    /// Width and height in texels, each at least 1.
    pub size: [u32; 2],
    /// Wrap modes, horizontal and vertical.
    pub wrap: [Wrap; 2],
    /// Red, green and blue of each texel; shared by textures of the same image.
    pub texels: Arc<[[u8; 3]]>,
}

/// Wrap mode of a texture beyond its edges.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Hash)]
pub enum Wrap {
    #[default]
    Repeat,
    /// The image again, every other one mirrored.
    Mirror,
    /// The texels of the edge.
    Clamp,
}

impl Wrap {
    /// The texel within `0..size` that is seen at `index` texels from the edge; `size` is at
    /// least 1.
    pub fn texel(self, index: i64, size: u32) -> u32 {
        let size = i64::from(size.max(1));
        let within = match self {
            Self::Repeat => index.rem_euclid(size),
            Self::Clamp => index.clamp(0, size - 1),
            Self::Mirror => {
                let there_and_back = index.rem_euclid(2 * size);
                there_and_back.min(2 * size - 1 - there_and_back)
            }
        };
        within as u32
    }
}

/// How finely the effects of a scene are sampled; each has a default.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename = "Effects", deny_unknown_fields, default)]
pub struct SampleWishes {
    /// Eye rays per pixel for its area.
    #[serde(deserialize_with = "number_of_samples")]
    #[cfg_attr(feature = "schema", schemars(range(min = 1, max = 65_536)))]
    pub supersamples: Option<u32>,
    /// Shadow rays per hit and light with a radius.
    #[serde(deserialize_with = "number_of_samples")]
    #[cfg_attr(feature = "schema", schemars(range(min = 1, max = 65_536)))]
    pub shadow: Option<u32>,
    /// Reflected rays a hit on a rough mirror.
    #[serde(deserialize_with = "number_of_samples")]
    #[cfg_attr(feature = "schema", schemars(range(min = 1, max = 65_536)))]
    pub glossy: Option<u32>,
    /// Eye rays per pixel for the time that the shutter is open.
    #[serde(deserialize_with = "number_of_samples")]
    #[cfg_attr(feature = "schema", schemars(range(min = 1, max = 65_536)))]
    pub temporal: Option<u32>,
    /// Eye rays per pixel for the area of the lens.
    #[serde(deserialize_with = "number_of_samples")]
    #[cfg_attr(feature = "schema", schemars(range(min = 1, max = 65_536)))]
    pub focal: Option<u32>,
}

impl SampleWishes {
    /// One sample of each.
    pub const ONE_OF_EACH: Self = Self {
        supersamples: Some(1),
        shadow: Some(1),
        glossy: Some(1),
        temporal: Some(1),
        focal: Some(1),
    };
}

/// Largest number of samples of one effect: more would take hours.
const MOST_SAMPLES: u32 = 65_536;

fn number_of_samples<'de, D: Deserializer<'de>>(from: D) -> Result<Option<u32>, D::Error> {
    let n = u32::deserialize(from)?;
    if (1..=MOST_SAMPLES).contains(&n) {
        return Ok(Some(n));
    }
    Err(D::Error::custom(format!("found {n}, expected 1 to {MOST_SAMPLES} samples")))
}

/// A camera in NFF's terms, with a thin lens and a shutter; a pinhole by default.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    pub from: DVec3,
    /// Point in the middle of the image.
    pub at: DVec3,
    /// Up; need not be perpendicular to the viewing direction.
    pub up: DVec3,
    /// Full field of view in degrees, from edge to edge of a square image.
    pub angle: f64,
    /// Distance to the near plane as stated by the file (informative: rays start at the eye).
    pub hither: f64,
    /// Width and height in pixels as stated by the file.
    pub resolution: [u32; 2],
    /// Radius of the lens in world units, >= 0; 0 is a pinhole.
    pub aperture: f64,
    /// Distance along the view at which the image is sharp, world units; `None` is that of `at`.
    pub focal_distance: Option<f64>,
    /// How long the shutter is open, in the unit of time of the velocities, >= 0.
    pub shutter: f64,
}

impl Default for Camera {
    fn default() -> Self {
        Self {
            from: DVec3::new(0.0, 0.0, 1.0),
            at: DVec3::ZERO,
            up: DVec3::Y,
            angle: 45.0,
            hither: 0.0,
            resolution: [512, 512],
            aperture: 0.0,
            focal_distance: None,
            shutter: 0.0,
        }
    }
}

impl Camera {
    /// Refuses cameras that have no view: no direction, no up, an angle outside (0, 180).
    pub(crate) fn check(&self, place: impl Fn() -> FilePlace) -> Result<(), LoadError> {
        let fail = |what: &str, found: String, expected: &str| {
            Err(LoadError::out_of_range(place(), format!("camera {what}"), found, expected))
        };
        if !(self.angle > 0.0 && self.angle < 180.0) {
            let expected = "more than 0 and less than 180 degrees";
            return fail("angle", self.angle.to_string(), expected);
        }
        let direction = self.at - self.from;
        if !(direction.length() > 0.0 && direction.length().is_finite()) {
            return fail("`at`", self.at.to_string(), "a point other than `from`");
        }
        if direction.normalize().cross(self.up.normalize_or_zero()).length() < 1e-9 {
            let expected = "a vector that is neither 0 nor along the view";
            return fail("`up`", self.up.to_string(), expected);
        }
        if self.resolution.contains(&0) {
            return fail("resolution", format!("{:?}", self.resolution), "at least 1 by 1");
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texels_beyond_the_edges() {
        let row = |wrap: Wrap| (-4..8).map(|i| wrap.texel(i, 3)).collect::<Vec<u32>>();
        assert_eq!(row(Wrap::Repeat), [2, 0, 1, 2, 0, 1, 2, 0, 1, 2, 0, 1]);
        assert_eq!(row(Wrap::Mirror), [2, 2, 1, 0, 0, 1, 2, 2, 1, 0, 0, 1]);
        assert_eq!(row(Wrap::Clamp), [0, 0, 0, 0, 0, 1, 2, 2, 2, 2, 2, 2]);
        for wrap in [Wrap::Repeat, Wrap::Mirror, Wrap::Clamp] {
            for index in [i64::MIN, i64::MAX] {
                assert!(wrap.texel(index, 3) < 3 && wrap.texel(index, 1) == 0);
            }
        }
    }
}
