//! One row per axis, scene and variant.

use csv::Writer;

use crate::accuracy::error_of::ErrorOf;
use crate::accuracy::record::{AccuracyRecord, PartTime};
use presentation::csv::written;
use presentation::format_error::FormatError;

/// The columns, in order.
pub const COLUMNS: [&str; 23] = [
    "axis",
    "scene",
    "subject",
    "variant",
    "setting",
    "metric",
    "reference",
    "error",
    "wrong",
    "trials",
    "reference_error",
    "below_reference",
    "time_s",
    "time_s_low",
    "time_s_high",
    "ratio_to_cheapest",
    "ratio_low",
    "ratio_high",
    "standing",
    "is_reference",
    "also",
    "seconds",
    "parts",
];

/// All finished axes.
///
/// # Errors
/// [`FormatError`].
pub fn to_string(run: &AccuracyRecord) -> Result<String, FormatError> {
    written(|writer| fill(writer, run))
}

/// Name and seconds by round.
fn part(part: &PartTime) -> String {
    let seconds: Vec<String> = part.seconds.iter().map(|s| format!("{s:e}")).collect();
    format!("{}={}", part.part, seconds.join(" "))
}

fn fill(writer: &mut Writer<Vec<u8>>, run: &AccuracyRecord) -> Result<(), csv::Error> {
    writer.write_record(COLUMNS)?;
    for axis in &run.axes {
        for scene in &axis.scenes {
            for row in &scene.rows {
                let (wrong, trials) = match row.error {
                    ErrorOf::Counted { wrong, trials } => (wrong.to_string(), trials.to_string()),
                    ErrorOf::Rmse { .. } => (String::new(), String::new()),
                };
                let also: Vec<String> = row.also.iter().map(|(n, x)| format!("{n}={x}")).collect();
                let seconds: Vec<String> = row.seconds.iter().map(|s| format!("{s:e}")).collect();
                writer.write_record([
                    axis.axis.clone(),
                    scene.scene.clone(),
                    scene.subject.clone(),
                    row.variant.clone(),
                    row.setting.clone(),
                    axis.metric.clone(),
                    axis.reference.clone(),
                    row.error.value().to_string(),
                    wrong,
                    trials,
                    scene.reference_error.to_string(),
                    row.is_below_reference.to_string(),
                    row.time_s.median.to_string(),
                    row.time_s.low.to_string(),
                    row.time_s.high.to_string(),
                    row.ratio.median.to_string(),
                    row.ratio.low.to_string(),
                    row.ratio.high.to_string(),
                    row.standing.name().to_owned(),
                    row.is_reference.to_string(),
                    also.join("; "),
                    seconds.join(" "),
                    row.parts.iter().map(part).collect::<Vec<_>>().join("; "),
                ])?;
            }
        }
    }
    Ok(())
}
