//! Everything, as JSON.

use crate::error::Error;
use crate::record::RunRecord;

/// The whole record.
///
/// # Errors
/// [`Error::Format`].
pub fn to_string(run: &RunRecord) -> Result<String, Error> {
    serde_json::to_string_pretty(run)
        .map(|text| text + "\n")
        .map_err(|e| Error::Format { format: "JSON", message: e.to_string() })
}
