//! One row a scene, structure and setting.

use crate::run::{kind_tables, picture_time, tables};
use measurement::record::{Outliers, RowRecord, RunRecord, SceneRecord, Verdict, WorkRecord};
use presentation::csv::{estimate, number, written};
use presentation::format_error::FormatError;
use presentation::numbers;

/// The columns, in order; behind them come those of [`kind_tables::csv_columns`].
pub const COLUMNS: [&str; 37] = [
    "scene",
    "primitives",
    "structure",
    "settings",
    "resolution",
    "n_in",
    "n_v",
    "n_ev",
    "n_oiv",
    "n_it",
    "n_ts",
    "n_ets",
    "n_eets",
    "saved_part",
    "answers",
    "rays",
    "memory_bytes",
    "pending_cells",
    "build_s",
    "build_s_low",
    "build_s_high",
    "trace_s",
    "trace_s_low",
    "trace_s_high",
    "render_s",
    "first_image_s",
    "ratio_to_reference",
    "ratio_low",
    "ratio_high",
    "primary_mrays",
    "shadow_mrays",
    "secondary_mrays",
    "diffuse_mrays",
    "mismatches",
    "verdict",
    "build_outliers",
    "trace_outliers",
];

/// All finished scenes.
///
/// # Errors
/// [`FormatError`].
pub fn to_string(run: &RunRecord) -> Result<String, FormatError> {
    written(|writer| {
        let kinds = kind_tables::kinds(run);
        let more = kind_tables::csv_columns(&kinds);
        writer.write_record(COLUMNS.map(str::to_owned).into_iter().chain(more))?;
        for scene in &run.scenes {
            let times = picture_time::of_scene(scene);
            for row in &scene.rows {
                let more = kind_tables::csv_fields(&kinds, row, &times, run.settings.seed);
                writer.write_record(fields(scene, row).into_iter().chain(more))?;
            }
        }
        Ok(())
    })
}

/// The fields of a row, one for each of [`COLUMNS`].
pub fn fields(scene: &SceneRecord, row: &RowRecord) -> Vec<String> {
    let mut fields = vec![
        scene.name.clone(),
        scene.primitives.to_string(),
        row.structure.clone(),
        row.settings.clone(),
    ];
    match &row.shape {
        Some(shape) => {
            fields.push(shape.resolution.map(numbers::resolution).unwrap_or_default());
            fields.extend([shape.n_in, shape.n_v, shape.n_ev, shape.n_oiv].map(|n| n.to_string()));
        }
        None => fields.extend(blanks(5)),
    }
    match &row.work {
        Some(work) => fields.extend(work.per_ray().map(|n| format!("{n:.6}"))),
        None => fields.extend(blanks(4)),
    }
    fields.push(number(row.work.as_ref().and_then(WorkRecord::saved_part)));
    fields.push(row.answers.name().to_owned());
    fields.push(row.rays.to_string());
    fields.push(row.shape.as_ref().map(|s| s.memory_bytes.to_string()).unwrap_or_default());
    let pending = row.shape.as_ref().and_then(|s| s.pending_cells);
    fields.push(pending.map(|n| n.to_string()).unwrap_or_default());
    fields.extend(estimate(row.build_s));
    fields.extend(estimate(row.trace_s));
    fields.push(number(row.render_s));
    fields.push(number(row.first_image_s()));
    fields.extend(estimate(row.ratio));
    fields.extend(tables::rates(row).map(number));
    use Verdict::{NotBuilt, OverLimit, Panicked};
    let judged = !matches!(row.verdict, NotBuilt | Panicked | OverLimit);
    fields.push(if judged { row.mismatches.to_string() } else { String::new() });
    fields.push(row.verdict.name().to_owned());
    let Outliers { build, trace } = row.outliers;
    fields.extend([build, trace].map(|[low, high]| match row.samples.is_empty() {
        true => String::new(),
        false => (low + high).to_string(),
    }));
    fields
}

fn blanks(n: usize) -> impl Iterator<Item = String> {
    std::iter::repeat_n(String::new(), n)
}
