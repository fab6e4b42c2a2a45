//! A check as Markdown and CSV.

use std::fmt::Write;

use crate::gate::report::{GLOSSARY, Report};
use presentation::csv::{number, written};
use presentation::format_error::FormatError;
use presentation::markdown::{escaped, push_table};

/// Columns of the CSV file.
pub const COLUMNS: [&str; 12] = [
    "stage",
    "scene",
    "row",
    "what",
    "baseline",
    "now",
    "change",
    "change_low",
    "change_high",
    "p",
    "outcome",
    "note",
];

/// Verdict, tables, remarks.
pub fn markdown(report: &Report, all: bool) -> String {
    let mut text =
        format!("# rtbench check: {}\n\n{}\n\n", report.outcome.name(), escaped(&report.verdict()));
    let improvements = report.improvements();
    for improvement in &improvements {
        let _ = writeln!(text, "- {}", escaped(improvement));
    }
    text += if improvements.is_empty() { "" } else { "\n" };
    for table in report.tables(all) {
        if table.rows.is_empty() {
            let (title, notes) = (escaped(&table.title), table.notes.join(" "));
            let _ = writeln!(text, "## {title}\n\n{}\n", escaped(&notes));
        } else {
            push_table(&mut text, &table);
        }
    }
    let remarks = report.remarks.iter().map(|remark| escaped(remark));
    for line in remarks.chain(GLOSSARY.iter().map(|&line| line.to_owned())) {
        let _ = writeln!(text, "{line}\n");
    }
    text
}

/// One row for each thing judged.
///
/// # Errors
/// [`FormatError`].
pub fn csv(report: &Report) -> Result<String, FormatError> {
    written(|writer| {
        writer.write_record(COLUMNS)?;
        for f in &report.findings {
            writer.write_record([
                f.stage.to_owned(),
                f.scene.clone(),
                f.row.clone(),
                f.quantity.to_owned(),
                number(f.baseline),
                number(f.now),
                number(f.change.map(|e| e.median)),
                number(f.change.map(|e| e.low)),
                number(f.change.map(|e| e.high)),
                // probabilities may be far smaller than nine digits show
                f.p.map(|p| format!("{p:e}")).unwrap_or_default(),
                f.outcome.name().to_owned(),
                f.note.clone(),
            ])?;
        }
        Ok(())
    })
}
