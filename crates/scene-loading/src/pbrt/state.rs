//! State that statements change for those that follow: transform, material, emission.

use std::collections::{BTreeMap, HashMap};
use std::rc::Rc;

use glam::{DMat4, DVec3, DVec4};

use crate::error::{FilePlace, LoadError};
use crate::limits;
use crate::pbrt::params::Params;
use crate::words::{Word, Words};

/// How deep attributes may nest.
const MAX_DEPTH: usize = 1 << 12;

/// The most named coordinate systems.
const MAX_SYSTEMS: usize = 1 << 16;

/// Attributes of the shapes that follow.
#[derive(Debug, Clone, Default)]
pub(super) struct Attributes {
    /// From the space of the shapes to the world.
    pub transform: DMat4,
    /// Index of the material; none is the default one.
    pub material: Option<u32>,
    /// Shapes are area lights.
    pub shines: bool,
    /// Transforms change the end of the exposure alone, which is not read.
    pub at_end: bool,
    /// Parameters set by `Attribute` for what follows: `shape`, `light` or `material`.
    pub inherited: BTreeMap<&'static str, Rc<Params>>,
}

/// The attributes, those that were saved, and named coordinate systems.
#[derive(Debug, Default)]
pub(super) struct State {
    pub now: Attributes,
    saved: Vec<Attributes>,
    pub systems: HashMap<String, DMat4>,
}

impl State {
    pub fn save(&mut self, place: impl FnOnce() -> FilePlace) -> Result<(), LoadError> {
        limits::check(self.saved.len() + 1, MAX_DEPTH, "the depth of attributes", place)?;
        self.saved.push(self.now.clone());
        Ok(())
    }

    pub fn restore(
        &mut self,
        directive: &str,
        place: impl FnOnce() -> FilePlace,
    ) -> Result<(), LoadError> {
        self.now = self
            .saved
            .pop()
            .ok_or_else(|| LoadError::syntax(place(), directive, "as many beginnings before it"))?;
        Ok(())
    }

    /// Does what a statement says of transforms and attributes; false where it is none of them.
    pub fn statement(&mut self, word: Word<'_>, words: &mut Words<'_>) -> Result<bool, LoadError> {
        let (path, line) = (words.path, word.line);
        let place = || FilePlace::line(path, line);
        let now = self.now.transform;
        let matrix = match word.text {
            "Identity" => DMat4::IDENTITY,
            "Translate" => {
                now * DMat4::from_translation(DVec3::from_array(words.numbers(word.text)?))
            }
            "Scale" => now * DMat4::from_scale(DVec3::from_array(words.numbers(word.text)?)),
            "Rotate" => {
                let [angle, x, y, z] = words.numbers(word.text)?;
                let axis = DVec3::new(x, y, z).try_normalize().ok_or_else(|| {
                    LoadError::syntax(place(), "Rotate", "an angle and an axis other than 0 0 0")
                })?;
                now * DMat4::from_axis_angle(axis, angle.to_radians())
            }
            "LookAt" => {
                let [a, b, c, d, e, f, g, h, i] = words.numbers(word.text)?;
                let look = look_at(DVec3::new(a, b, c), DVec3::new(d, e, f), DVec3::new(g, h, i));
                let look = look.ok_or_else(|| {
                    let expected = "an eye, another point, and an up not along the view";
                    LoadError::syntax(place(), "LookAt", expected)
                })?;
                now * look
            }
            "Transform" => DMat4::from_cols_array(&words.numbers(word.text)?),
            "ConcatTransform" => now * DMat4::from_cols_array(&words.numbers(word.text)?),
            "CoordSysTransform" => {
                let name = words.name("name")?;
                let expected = "a coordinate system before it";
                let system = self.systems.get(&name).copied();
                system.ok_or_else(|| LoadError::syntax(place(), &name, expected))?
            }
            "CoordinateSystem" => {
                let name = words.name("name")?;
                return self.name_system(&name, now, place).map(|()| true);
            }
            "ActiveTransform" => {
                let which = words.any("StartTime, EndTime or All")?;
                self.now.at_end = which.text == "EndTime";
                return Ok(true);
            }
            "AttributeBegin" | "TransformBegin" => return self.save(place).map(|()| true),
            "AttributeEnd" | "TransformEnd" => {
                return self.restore(word.text, place).map(|()| true);
            }
            _ => return Ok(false),
        };
        if !self.now.at_end {
            if !matrix.is_finite() {
                return Err(LoadError::not_finite(place(), "a transform", "not finite"));
            }
            self.now.transform = matrix;
        }
        Ok(true)
    }

    /// Attributes that are saved now.
    pub fn depth(&self) -> usize {
        self.saved.len()
    }

    pub fn name_system(
        &mut self,
        name: &str,
        matrix: DMat4,
        place: impl FnOnce() -> FilePlace,
    ) -> Result<(), LoadError> {
        let count = self.systems.len() + 1;
        limits::check(count, MAX_SYSTEMS, "the number of coordinate systems", place)?;
        self.systems.insert(name.to_owned(), matrix);
        Ok(())
    }
}

/// `LookAt`: from the world to a camera that looks along its z axis, y up, in a left-handed space.
/// None where nothing is seen that way.
fn look_at(from: DVec3, at: DVec3, up: DVec3) -> Option<DMat4> {
    let along = (at - from).try_normalize()?;
    let right = up.cross(along).try_normalize()?;
    let above = along.cross(right);
    let column = |v: DVec3| v.extend(0.0);
    let to_world = DMat4::from_cols(column(right), column(above), column(along), from.extend(1.0));
    Some(to_world.inverse()).filter(DMat4::is_finite)
}

/// The factor by which a transform scales all lengths; none where that differs by direction.
pub(crate) fn uniform_scale(matrix: &DMat4) -> Option<f64> {
    let [x, y, z] = [matrix.x_axis, matrix.y_axis, matrix.z_axis].map(DVec4::truncate);
    let scale = x.length();
    let slack = scale * 1e-6;
    let same = (y.length() - scale).abs() <= slack && (z.length() - scale).abs() <= slack;
    let square = [x.dot(y), y.dot(z), z.dot(x)].iter().all(|dot| dot.abs() <= slack * scale);
    (same && square && scale > 0.0).then_some(scale)
}
