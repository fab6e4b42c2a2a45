//! Helpers for all JSON files: errors with a position, and names taken from files.

use std::path::Path;

use crate::error::{FilePlace, LoadError};
use crate::scene::{Scene, checked};
use serde::de::Deserializer;

/// Parses JSON; errors carry file, line and column.
pub(crate) fn from_json<T: serde::de::DeserializeOwned>(
    path: &Path,
    text: &str,
) -> Result<T, LoadError> {
    serde_json::from_str(text).map_err(|error| {
        let message = error.to_string();
        // The position is in our own fields already.
        let message = message.split(" at line ").next().unwrap_or_default().to_string();
        LoadError::Json {
            place: FilePlace::line(path, error.line()),
            column: error.column(),
            message,
        }
    })
}

/// The name inside a scene or set file must be the one it is found by.
pub(crate) fn check_name(path: &Path, name: &str) -> Result<(), LoadError> {
    let stem = path.file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default();
    if stem == name {
        return Ok(());
    }
    Err(LoadError::syntax(
        FilePlace::file(path),
        name,
        format!("the name `{stem}`, as the file has"),
    ))
}

/// The most names of materials that an error lists.
const MAX_NAMES: usize = 100;

/// The error for a material that a scene does not have, where it says what was expected.
pub(crate) fn unknown_material(
    path: &Path,
    name: &str,
    scene: &Scene,
    expected: &str,
) -> LoadError {
    let names: Vec<&str> =
        scene.materials.iter().take(MAX_NAMES).map(|m| m.name.as_str()).collect();
    let more = if scene.materials.len() > MAX_NAMES { ", ..." } else { "" };
    let expected = format!("{expected}: {}{more}", names.join(", "));
    LoadError::syntax(FilePlace::file(path), name, expected)
}

/// A length that may be missing but not 0.
pub(crate) fn above_0<'de, D: Deserializer<'de>>(from: D) -> Result<Option<f64>, D::Error> {
    checked(from, |x| x > 0.0, "a number above 0").map(Some)
}

pub(crate) fn share<'de, D: Deserializer<'de>>(from: D) -> Result<Option<f64>, D::Error> {
    checked(from, |x| (0.0..=1.0).contains(&x), "a number from 0 to 1").map(Some)
}
