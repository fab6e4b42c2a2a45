//! A scene in several sizes as CSV: a row for each size and row, and a row for each slope.

use crate::run::columns::RowOf;
use crate::run::csv as run_csv;
use crate::sweep::sizes::columns::{SizeRow, columns};
use measurement::record::RunRecord;
use presentation::column;
use presentation::csv::{number, written};
use presentation::format_error::FormatError;

/// All finished sizes: their own columns, then those of a run.
///
/// # Errors
/// [`FormatError`].
pub fn sizes(run: &RunRecord) -> Result<String, FormatError> {
    let columns = columns();
    written(|writer| {
        writer.write_record(column::keys(&columns).chain(run_csv::keys()))?;
        for scene in &run.scenes {
            let size = run.scale.as_ref().and_then(|scale| scale.size(&scene.name));
            for row in &scene.rows {
                let of = SizeRow { of: RowOf { scene, row, all_rays: 0 }, size };
                let own = column::fields(&columns, &of);
                writer.write_record(own.chain(run_csv::fields(scene, row)))?;
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
