//! JSON for people to read.

use serde::Serialize;

/// Anything, with a line break behind it.
pub fn written(value: &impl Serialize) -> Result<String, FormatError> {
    Ok(serde_json::to_string_pretty(value)? + "\n")
}

impl From<serde_json::Error> for FormatError {
    fn from(error: serde_json::Error) -> Self {
        Self { format: "JSON", message: error.to_string() }
    }
}

/// Results could not be turned into text.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("cannot write the results as {format}: {message}")]
pub struct FormatError {
    pub format: &'static str,
    pub message: String,
}
