//! A scene in several sizes as CSV: a row for each size and row, and a row for each slope.

use crate::run::csv as run_csv;
use crate::scale::quantities::trace_s_per_ray;
use measurement::record::RunRecord;
use presentation::csv::{number, written};
use presentation::format_error::FormatError;

/// The columns before those of a run.
const OWN: [&str; 6] = [
    "asked_primitives",
    "build_ns_per_primitive",
    "trace_ns_per_ray",
    "bytes_per_primitive",
    "peak_build_bytes",
    "reason",
];

/// All finished sizes: what was asked for and the quantities that are compared, then the columns of
/// a run. `reason` says why a row was not measured.
///
/// # Errors
/// [`FormatError`].
pub fn sizes(run: &RunRecord) -> Result<String, FormatError> {
    written(|writer| {
        writer.write_record(OWN.iter().chain(&run_csv::COLUMNS))?;
        for scene in &run.scenes {
            let size = run.scale.as_ref().and_then(|scale| scale.size(&scene.name));
            let asked = size.iter().flat_map(|size| &size.asked).map(u64::to_string);
            let asked = asked.collect::<Vec<_>>().join("; ");
            let each = |x: f64| x / scene.primitives.max(1) as f64;
            for row in &scene.rows {
                let bytes = row.shape.as_ref().map(|s| s.memory_bytes as f64);
                let mut fields = vec![
                    asked.clone(),
                    number(row.build_s.map(|e| each(e.median) * 1e9)),
                    number(trace_s_per_ray(row).map(|e| e.median * 1e9)),
                    number(bytes.map(each)),
                    row.peak_build_bytes.map(|n| n.to_string()).unwrap_or_default(),
                    row.error.clone().unwrap_or_default(),
                ];
                fields.extend(run_csv::fields(scene, row));
                writer.write_record(fields)?;
            }
        }
        Ok(())
    })
}

/// How each quantity of each row grows.
///
/// # Errors
/// [`FormatError`].
pub fn slopes(run: &RunRecord) -> Result<String, FormatError> {
    written(|writer| {
        let columns =
            ["scene", "structure", "settings", "quantity", "sizes", "slope", "low", "high"];
        writer.write_record(columns)?;
        if let Some(scale) = &run.scale {
            for slope in &scale.slopes {
                writer.write_record([
                    scale.scene.clone(),
                    slope.structure.clone(),
                    slope.settings.clone(),
                    slope.quantity.clone(),
                    slope.sizes.to_string(),
                    number(Some(slope.slope)),
                    number(slope.low),
                    number(slope.high),
                ])?;
            }
        }
        Ok(())
    })
}
