//! The programs outside whose times were merged into a run: a table of their own, so that nobody
//! takes a time that was told for one that was measured.

use measurement::record::SceneRecord;
use presentation::numbers;
use presentation::table::Table;

use crate::run::columns::{RowOf, columns};
use presentation::column::headed;

/// Note below the table.
const NOTE: &str = "foreign: another program. It reported its times itself, on its own hardware; \
                    its answers were checked from a file (`rtbench hits check`). It is in no \
                    ratio, mean or comparison.";

/// The foreign rows of a scene; none where there are none.
pub fn table(scene: &SceneRecord) -> Option<Table> {
    let columns = columns();
    let shown: Vec<_> = ["rays", "build ms", "trace ms", "verdict"]
        .into_iter()
        .filter_map(|head| headed(&columns, head))
        .collect();
    let mut header = vec!["program (foreign)"];
    header.extend(shown.iter().map(|column| column.head));
    header.push("Mrays/s");
    let all_rays = scene.distinct_rays();
    let mut notes = vec![NOTE.to_owned()];
    let rows: Vec<_> = scene
        .foreign
        .iter()
        .map(|row| {
            let of = RowOf { scene, row, all_rays };
            let example = row.example.as_ref().filter(|_| row.mismatches > 0);
            notes.extend(example.map(|example| format!("{}: {example}", row.label())));
            let mut cells = vec![row.label().into()];
            cells.extend(shown.iter().map(|column| column.cell(&of)));
            let rate = row.trace_s.map(|s| numbers::short(row.rays as f64 / s.median / 1e6));
            cells.push(rate.unwrap_or_else(|| "-".into()).into());
            cells
        })
        .collect();
    let title = format!("{}: foreign rows", scene.name);
    (!rows.is_empty()).then_some(Table { title, header, rows, notes })
}
