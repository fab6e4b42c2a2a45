//! A check as Markdown and CSV.

use std::fmt::Write;

use crate::gate::columns::columns;
use crate::gate::report::{GLOSSARY, Report};
use presentation::column;
use presentation::json::FormatError;
use presentation::markdown::{escaped, push_table};

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
    let missing = report.missing_in_words();
    let remarks = missing.iter().chain(&report.remarks).map(|remark| escaped(remark));
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
    column::csv(&columns(), &report.findings)
}
