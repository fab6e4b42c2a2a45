//! JSON for people to read.

use serde::Serialize;

/// Anything, with a line break behind it.
pub fn written(value: &impl Serialize) -> Result<String, FormatError> {
    serde_json::to_string_pretty(value)
        .map(|text| text + "\n")
        .map_err(|e| FormatError { format: "JSON", message: e.to_string() })
}

/// Results could not be turned into text.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("cannot write the results as {format}: {message}")]
pub struct FormatError {
    pub format: &'static str,
    /// Message of the library.
    pub message: String,
}
