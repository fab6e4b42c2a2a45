//! A camera and lights that are said from outside: what the command line gives scenes instead of
//! their own, or because they have none.
//!
//! Each has a text, by which it is typed and recorded; numbers are printed so that they are read
//! back bit for bit.

use std::fmt;
use std::path::Path;
use std::str::FromStr;

use glam::DVec3;
use serde::{Deserialize, Serialize};

use crate::error::{FilePlace, LoadError};
use crate::mesh::is_usable;
use crate::scene::{Light, Rgb, Scene};

/// What replaces the view and the lights of a scene; what is not said stays the scene's own.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct ViewOptions {
    /// Eye and point in the middle of the image.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(with = "Option<String>"))]
    pub camera: Option<CameraOption>,
    /// Up.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(with = "Option<String>"))]
    pub up: Option<UpOption>,
    /// All lights, where there is one.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    #[cfg_attr(feature = "schema", schemars(with = "Vec<String>"))]
    pub lights: Vec<LightOption>,
}

#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct CameraOption {
    /// Eye, world units.
    pub from: DVec3,
    /// Point in the middle of the image, world units.
    pub at: DVec3,
    /// Full field of view in degrees; none leaves the scene's.
    pub angle: Option<f64>,
}

/// `X,Y,Z`, a direction other than 0, world units.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct UpOption(pub DVec3);

/// `POS[:COLOR]`, as `0,10,0` or `0,10,0:1,0.9,0.8`: a point light without falloff.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct LightOption {
    /// Where it is, world units.
    pub position: DVec3,
    /// Its colour; see [`Light::color`] for its absence.
    pub color: Option<Rgb>,
}

impl ViewOptions {
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// What was typed, as arguments: `--camera`, `--up`, `--light`.
    pub fn arguments(&self) -> Vec<String> {
        let camera = self.camera.iter().map(|camera| format!("--camera={camera}"));
        let up = self.up.iter().map(|up| format!("--up={up}"));
        let lights = self.lights.iter().map(|light| format!("--light={light}"));
        camera.chain(up).chain(lights).collect()
    }

    /// Gives a scene the view and the lights that are said, in the coordinates of its file.
    ///
    /// # Errors
    /// [`LoadError::OutOfRange`] for a camera that sees nothing: without direction, with `up` along
    /// it.
    pub fn apply(&self, scene: &mut Scene) -> Result<(), LoadError> {
        let origin = scene.origin;
        let camera = &mut scene.camera;
        if let Some(CameraOption { from, at, angle }) = self.camera {
            (camera.from, camera.at) = (from - origin, at - origin);
            camera.angle = angle.unwrap_or(camera.angle);
            // a lens is focused where its own camera looks
            camera.focal_distance = None;
        }
        camera.up = self.up.map_or(camera.up, |up| up.0);
        if self.camera.is_some() || self.up.is_some() {
            let place = format!("--camera, --up (scene {})", scene.name);
            camera.check(|| FilePlace::file(Path::new(&place)))?;
        }
        if !self.lights.is_empty() {
            let near = |light: &LightOption| Light::point(light.position - origin, light.color);
            scene.lights = self.lights.iter().map(near).collect();
        }
        Ok(())
    }
}

/// A light at the eye for a scene that has none, and a warning that says so: without one every
/// surface is black and there are no shadow rays.
pub(crate) fn light_if_dark(scene: &mut Scene) {
    if scene.lights.is_empty() {
        scene.lights.push(Light::point(scene.camera.from, None));
        let text = "no lights: added one at the eye; set others with --light X,Y,Z or a scene file";
        scene.warn(text);
    }
}

impl fmt::Display for ViewOptions {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.arguments().join(" "))
    }
}

impl FromStr for CameraOption {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parts: Vec<&str> = text.split(':').collect();
        let (from, at, angle) = match parts.as_slice() {
            [from, at] => (from, at, None),
            [from, at, angle] => (from, at, Some(number(angle)?)),
            _ => return Err("expected FROM:AT or FROM:AT:FOV, as 1,2,3:0,0,0:45".into()),
        };
        if angle.is_some_and(|angle| !(angle > 0.0 && angle < 180.0)) {
            return Err("expected a field of view above 0 and below 180 degrees".into());
        }
        let camera = Self { from: point(from)?, at: point(at)?, angle };
        if camera.from == camera.at {
            return Err("FROM and AT are the same point".into());
        }
        Ok(camera)
    }
}

impl fmt::Display for CameraOption {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}", shown(self.from.to_array()), shown(self.at.to_array()))?;
        self.angle.map_or(Ok(()), |angle| write!(f, ":{angle}"))
    }
}

impl FromStr for LightOption {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (position, color) = match text.split_once(':') {
            Some((position, color)) => (position, Some(numbers(color)?)),
            None => (text, None),
        };
        if color.is_some_and(|color: Rgb| color.iter().any(|&share| share < 0.0)) {
            return Err("expected a colour R,G,B of shares of at least 0".into());
        }
        Ok(Self { position: point(position)?, color })
    }
}

impl fmt::Display for LightOption {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&shown(self.position.to_array()))?;
        self.color.map_or(Ok(()), |color| write!(f, ":{}", shown(color)))
    }
}

impl FromStr for UpOption {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let up = point(text)?;
        if up == DVec3::ZERO {
            return Err("expected a direction other than 0,0,0".into());
        }
        Ok(Self(up))
    }
}

impl fmt::Display for UpOption {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&shown(self.0.to_array()))
    }
}

/// Options that are recorded as they are typed.
macro_rules! recorded_as_typed {
    ($($option:ty),*) => {$(
        impl TryFrom<String> for $option {
            type Error = String;

            fn try_from(text: String) -> Result<Self, String> {
                text.parse()
            }
        }

        impl From<$option> for String {
            fn from(option: $option) -> Self {
                option.to_string()
            }
        }
    )*};
}
recorded_as_typed!(CameraOption, UpOption, LightOption);

fn point(text: &str) -> Result<DVec3, String> {
    numbers(text).map(DVec3::from_array)
}

fn numbers(text: &str) -> Result<[f64; 3], String> {
    let values = text.split(',').map(number).collect::<Result<Vec<f64>, String>>()?;
    values.try_into().map_err(|_| format!("found `{text}`, expected three numbers: X,Y,Z"))
}

fn number(text: &str) -> Result<f64, String> {
    let value: Option<f64> = text.trim().parse().ok();
    let value = value.filter(|&value| is_usable(value));
    value.ok_or_else(|| format!("found `{text}`, expected a number of at most 1e100 in size"))
}

/// Three numbers with commas between them.
fn shown([x, y, z]: [f64; 3]) -> String {
    format!("{x},{y},{z}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_are_read_back() {
        for text in ["1,2,3:0,0,0:45", "-1e3,0.1,2:0,0,-7"] {
            let camera: CameraOption = text.parse().unwrap();
            assert_eq!(camera.to_string().parse(), Ok(camera), "{text}");
        }
        let third = DVec3::new(1.0 / 3.0, -1e-9, 1e22);
        let light = LightOption { position: third, color: Some([0.1, 1.0, 2.0 / 3.0]) };
        assert_eq!(light.to_string().parse(), Ok(light));
        let options = ViewOptions {
            camera: "1,2,3:0,0,0".parse().ok(),
            up: Some(UpOption(third)),
            lights: vec![light; 2],
        };
        let text = serde_json::to_string(&options).unwrap();
        assert_eq!(serde_json::from_str::<ViewOptions>(&text).unwrap(), options, "{text}");
        assert_eq!(serde_json::to_string(&ViewOptions::default()).unwrap(), "{}");
        for wrong in [r#"{"camera":"1,2,3"}"#, r#"{"up":"0,0,0"}"#, r#"{"size":"3"}"#] {
            assert!(serde_json::from_str::<ViewOptions>(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn invalid_cameras_are_errors_that_name_valid_ones() {
        for (text, part) in [
            ("1,2,3", "FROM:AT"),
            ("1,2,3:1,2,3", "same point"),
            ("1,2:0,0,0", "X,Y,Z"),
            ("1,2,x:0,0,0", "`x`"),
            ("1,2,nan:0,0,0", "`nan`"),
            ("1,2,1e300:0,0,0", "1e100"),
            ("1,2,3:0,0,0:180", "below 180"),
        ] {
            let error = text.parse::<CameraOption>().unwrap_err();
            assert!(error.contains(part), "{text}: {error}");
        }
        assert!("1,2,3:1,-1,0".parse::<LightOption>().unwrap_err().contains("at least 0"));
        assert!("0,0,0".parse::<UpOption>().unwrap_err().contains("0,0,0"));
    }

    #[test]
    fn given_views_replace_those_of_the_scene() {
        let mut scene = Scene::new("a");
        let options = ViewOptions {
            camera: "0,0,5:0,0,0".parse().ok(),
            up: Some(UpOption(DVec3::X)),
            lights: vec!["1,2,3".parse().unwrap()],
        };
        scene.camera.angle = 30.0;
        options.apply(&mut scene).unwrap();
        let camera = &scene.camera;
        assert_eq!((camera.from.z, camera.angle, camera.up), (5.0, 30.0, DVec3::X));
        assert_eq!(scene.lights.len(), 1);
        light_if_dark(&mut scene);
        assert_eq!((scene.lights.len(), scene.warnings.len()), (1, 0));
        // a camera that looks along `up` is refused, whoever said which
        let error = ViewOptions { up: Some(UpOption(DVec3::Z)), ..ViewOptions::default() }
            .apply(&mut scene)
            .unwrap_err();
        assert!(error.to_string().starts_with("--camera, --up (scene a): camera `up`"), "{error}");
    }
}
