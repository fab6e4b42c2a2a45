//! The camera of a scene, and how finely its effects are sampled.

use glam::DVec3;
use serde::de::Error;
use serde::{Deserialize, Deserializer};

use crate::error::{FilePlace, LoadError};

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
