//! One row per scene, structure and setting.

use measurement::record::{RowRecord, RunRecord, SceneRecord};
use presentation::column;
use presentation::csv::written;
use presentation::format_error::FormatError;

use crate::run::columns::{RowOf, columns};
use crate::run::kind_tables;
use crate::run::time_to_image::TimesToImage;

/// All finished scenes: [`columns`], and behind them those of [`kind_tables::csv_columns`].
///
/// # Errors
/// [`FormatError`].
pub fn to_string(run: &RunRecord) -> Result<String, FormatError> {
    written(|writer| {
        let kinds = kind_tables::kinds(run);
        let more = kind_tables::csv_columns(&kinds);
        writer.write_record(keys().map(str::to_owned).chain(more))?;
        for scene in &run.scenes {
            let times = TimesToImage::of(scene);
            for row in scene.rows.iter().chain(&scene.foreign) {
                let more = kind_tables::csv_fields(&kinds, row, &times);
                writer.write_record(fields(scene, row).into_iter().chain(more))?;
            }
        }
        Ok(())
    })
}

/// The names of [`columns`].
pub fn keys() -> impl Iterator<Item = &'static str> {
    column::keys(&columns()).collect::<Vec<_>>().into_iter()
}

/// The fields of a row, one for each of [`keys`].
pub fn fields(scene: &SceneRecord, row: &RowRecord) -> Vec<String> {
    column::fields(&columns(), &RowOf { scene, row, all_rays: 0 }).collect()
}
