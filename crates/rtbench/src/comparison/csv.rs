//! Comparisons as CSV: one row per scene, row and metric; geometric means have no scene, and what
//! was left out has no metric.

use crate::comparison::Comparison;
use presentation::csv::{estimate, number, written};
use presentation::json::FormatError;
use statistics::verdict::Change;

/// The columns, in order.
pub const COLUMNS: [&str; 14] = [
    "old_file",
    "new_file",
    "scene",
    "structure",
    "settings",
    "metric",
    "unit",
    "old",
    "new",
    "ratio",
    "ratio_low",
    "ratio_high",
    "p",
    "outcome",
];

pub fn to_string(comparisons: &[Comparison]) -> Result<String, FormatError> {
    written(|writer| {
        writer.write_record(COLUMNS)?;
        for comparison in comparisons {
            let files = [&*comparison.old.path, &*comparison.new.path];
            for scene in &comparison.scenes {
                for e in &scene.entries {
                    let Change { old, new, ratio, p, .. } = e.change;
                    let [old, new, p] = [Some(old), Some(new), p].map(number);
                    let [ratio, low, high] = estimate(ratio);
                    let row = [&*scene.scene, &*e.structure, &*e.settings, e.metric, e.unit];
                    let figures = [&*old, &*new, &*ratio, &*low, &*high, &*p, e.outcome.name()];
                    writer.write_record(files.iter().chain(&row).chain(&figures))?;
                }
                for out in &scene.left_out {
                    let row = [&*scene.scene, &*out.structure, &*out.settings];
                    let figures = ["", "", "", "", "", "", "", "", &*out.why];
                    writer.write_record(files.iter().chain(&row).chain(&figures))?;
                }
            }
            for mean in &comparison.means {
                let [ratio, low, high] = estimate(mean.ratio);
                let p = number(mean.p);
                let row = ["", &*mean.structure, &*mean.settings, mean.metric];
                let figures = ["", "", "", &*ratio, &*low, &*high, &*p, mean.outcome.name()];
                writer.write_record(files.iter().chain(&row).chain(&figures))?;
            }
        }
        Ok(())
    })
}
