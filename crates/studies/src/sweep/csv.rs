//! A sweep as CSV: one row per scene and value.

use crate::run::csv as run_csv;
use crate::sweep::Sweep;
use crate::sweep::judgement::judge;
use measurement::record::RunRecord;
use presentation::csv::{number, written};
use presentation::format_error::FormatError;

/// The columns before those of a run.
const OWN: [&str; 5] = ["parameter", "value", "marks", "cells_per_primitive", "to_best"];

/// All finished scenes: the parameter, its value and the marks, then the columns of a run.
///
/// # Errors
/// [`FormatError`].
pub fn to_string(sweep: &Sweep<'_>, run: &RunRecord) -> Result<String, FormatError> {
    written(|writer| {
        writer.write_record(OWN.into_iter().chain(run_csv::keys()))?;
        for scene in &run.scenes {
            let judgements = judge(sweep, scene);
            for ((row, line), judgement) in scene.rows.iter().zip(&sweep.lines).zip(judgements) {
                let mut fields = vec![
                    sweep.parameter.name.to_owned(),
                    line.value.clone().unwrap_or_default(),
                    judgement.marks.join("; "),
                    number(judgement.cells_per_primitive),
                    number(judgement.to_best),
                ];
                fields.extend(run_csv::fields(scene, row));
                writer.write_record(fields)?;
            }
        }
        Ok(())
    })
}
