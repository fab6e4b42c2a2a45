//! JSON for people to read.

use serde::Serialize;

use crate::format_error::FormatError;

/// Anything, with a line break behind it.
///
/// # Errors
/// [`FormatError`].
pub fn written(value: &impl Serialize) -> Result<String, FormatError> {
    serde_json::to_string_pretty(value)
        .map(|text| text + "\n")
        .map_err(|e| FormatError { format: "JSON", message: e.to_string() })
}
