//! Everything, as JSON.

use serde::Serialize;

use crate::error::Error;
use crate::record::RunRecord;

/// The whole record.
///
/// # Errors
/// [`Error::Format`].
pub fn to_string(run: &RunRecord) -> Result<String, Error> {
    written(run)
}

/// Anything, for people to read, with a line break behind it.
///
/// # Errors
/// [`Error::Format`].
pub fn written(value: &impl Serialize) -> Result<String, Error> {
    serde_json::to_string_pretty(value)
        .map(|text| text + "\n")
        .map_err(|e| Error::Format { format: "JSON", message: e.to_string() })
}
