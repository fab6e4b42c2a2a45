//! An explanation as CSV: one row per scene, kind of ray and row or factor.

use crate::explain::table::rays_of;
use crate::explain::{Explain, Explanation};
use measurement::record::RunRecord;
use presentation::csv::{estimate, written};
use presentation::format_error::FormatError;

const COLUMNS: [&str; 10] = [
    "scene",
    "rays",
    "part",
    "name",
    "structure",
    "craft",
    "ratio",
    "ratio_low",
    "ratio_high",
    "verdict",
];

/// All finished scenes: of each kind of ray the rows, the factors and the whole.
///
/// # Errors
/// [`FormatError`].
pub fn to_string(explain: &Explain<'_>, run: &RunRecord) -> Result<String, FormatError> {
    written(|writer| {
        writer.write_record(COLUMNS)?;
        for scene in &run.scenes {
            let explanation = Explanation::of(explain, run, scene);
            for rays in rays_of(run, scene) {
                let mut write = |words: [&str; 4], ratio, verdict: &str| {
                    let words = [scene.name.as_str(), rays.name()].into_iter().chain(words);
                    let [median, low, high] = estimate(ratio);
                    let numbers = [&*median, &*low, &*high, verdict];
                    writer.write_record(words.chain(numbers))
                };
                for (row, variant) in scene.rows.iter().zip(&explanation.variants) {
                    let Some(variant) = variant else { continue };
                    let words = ["row", &row.label(), &variant.structure, variant.craft.name()];
                    write(words, rays.ratio(row), row.verdict.name())?;
                }
                for factor in &explanation.factors {
                    let ratio = explanation.factor(factor, rays);
                    write(["factor", &factor.name, "", ""], ratio, "")?;
                }
                let whole = scene.rows.get(explain.row).filter(|_| !explanation.factors.is_empty());
                if let Some(row) = whole {
                    let words = ["whole", &row.label(), "", ""];
                    write(words, rays.ratio(row), row.verdict.name())?;
                }
            }
        }
        Ok(())
    })
}
