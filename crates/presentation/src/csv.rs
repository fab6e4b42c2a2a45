//! CSV: fields and files.

use csv::Writer;

use crate::format_error::FormatError;
use statistics::estimate::Estimate;

/// The text that `fill` writes.
///
/// # Errors
/// [`FormatError`].
pub fn written(
    fill: impl FnOnce(&mut Writer<Vec<u8>>) -> Result<(), csv::Error>,
) -> Result<String, FormatError> {
    let format = |message: String| FormatError { format: "CSV", message };
    let mut writer = Writer::from_writer(Vec::new());
    fill(&mut writer).map_err(|e| format(e.to_string()))?;
    let bytes = writer.into_inner().map_err(|e| format(e.to_string()))?;
    String::from_utf8(bytes).map_err(|e| format(e.to_string()))
}

/// A number as the columns have it; empty when there is none.
pub fn number(x: Option<f64>) -> String {
    x.map(|x| format!("{x:.9}")).unwrap_or_default()
}

/// A median and the ends of its interval as the columns have them.
pub fn estimate(e: Option<Estimate>) -> [String; 3] {
    [number(e.map(|e| e.median)), number(e.map(|e| e.low)), number(e.map(|e| e.high))]
}
