//! The rules of the format that the crate `gltf` checks, and those of its checks that do not count:
//! where it is stricter than the specification, and where what is missing is not needed.

use std::path::Path;

use ::gltf::json::validation::{Checked, Error, Validate};
use ::gltf::json::{Root, camera::Type};

use crate::error::{FilePlace, LoadError};

/// The most faults that an error names.
const MAX_FAULTS: usize = 8;

pub(super) fn check(path: &Path, json: &Root) -> Result<(), LoadError> {
    check_before_validation(path, json)?;
    let mut faults = Vec::new();
    json.validate(json, ::gltf::json::Path::new, &mut |place, error| {
        let place = place();
        if faults.len() < MAX_FAULTS && !is_allowed(place.as_str(), error) {
            faults.push(format!("{place}: {error}"));
        }
    });
    if faults.is_empty() {
        return Ok(());
    }
    Err(parser_error(path, format!("invalid glTF: {}", faults.join("; "))))
}

/// An error of the crate, in its words.
pub(super) fn parser_error(path: &Path, message: String) -> LoadError {
    LoadError::Parser { place: FilePlace::file(path), parser: "gltf", message }
}

/// Returns whether the crate finds a fault where the file can be read all the same.
fn is_allowed(place: &str, error: Error) -> bool {
    let is_position = place.starts_with("meshes[") && place.contains("attributes[\"POSITION\"]");
    match error {
        // `extensions` decides about these
        Error::Unsupported => true,
        // an accessor without data is all zeros; a texture may have its image in an extension; a
        // primitive without positions is to be skipped; bounds of positions are not used
        Error::Missing => {
            is_position
                || place.starts_with("accessors[") && place.ends_with(".bufferView")
                || place.starts_with("textures[") && place.ends_with(".source")
        }
        // attributes of one's own begin with an underscore; extensions have paths of their own
        Error::Invalid => {
            is_position
                || place.ends_with("attributes[\"<invalid semantic name>\"]")
                || place.starts_with("animations[") && place.ends_with(".target.path")
        }
        _ => false,
    }
}

/// Checks that prevent panics in the crate's own validation (1.4.1) or later.
fn check_before_validation(path: &Path, json: &Root) -> Result<(), LoadError> {
    let accessors = json.accessors.len();
    for (m, mesh) in json.meshes.iter().enumerate() {
        for (p, primitive) in mesh.primitives.iter().enumerate() {
            let accessor = primitive.attributes.values().find(|i| i.value() >= accessors);
            if let Some(index) = accessor {
                let what = format!("mesh {m} primitive {p}: accessor");
                let valid = format!("there are {accessors}, counted from 0");
                let place = FilePlace::file(path);
                return Err(LoadError::bad_index(place, what, index.value(), valid));
            }
        }
    }
    for (c, camera) in json.cameras.iter().enumerate() {
        let described = match camera.type_ {
            Checked::Valid(Type::Perspective) => camera.perspective.is_some(),
            Checked::Valid(Type::Orthographic) => camera.orthographic.is_some(),
            Checked::Invalid => true,
        };
        if !described {
            let (found, expected) =
                ("a type without its properties", "an object named as its type");
            return Err(LoadError::gltf(path, format!("camera {c}"), found, expected));
        }
    }
    Ok(())
}
