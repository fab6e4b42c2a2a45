//! A check as Markdown and CSV, and as annotations of GitHub Actions.

use crate::gate::evidence::{Finding, GateOutcome};
use crate::gate::report::{GLOSSARY, Report, columns};
use presentation::column;
use presentation::json::FormatError;
use presentation::markdown::{escaped, push_table};
use presentation::outside::Annotation;
use std::fmt::Write;

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
pub fn csv(report: &Report) -> Result<String, FormatError> {
    column::csv(&columns(), &report.findings)
}

/// GitHub shows no more than that of a level in a step.
const MOST_ANNOTATIONS: usize = 10;

/// The annotations of a check: errors for regressions and wrong hits, warnings for what is
/// inconclusive.
pub fn annotations(report: &Report) -> Vec<Annotation> {
    let of = |level: &[GateOutcome]| -> Vec<&Finding> {
        let mut found: Vec<_> =
            report.findings.iter().filter(|f| level.contains(&f.outcome)).collect();
        found.sort_by_key(|f| std::cmp::Reverse(f.outcome));
        found
    };
    let mut annotations = Vec::new();
    for (level, found) in [
        ("error", of(&[GateOutcome::WrongHits, GateOutcome::Regression])),
        ("warning", of(&[GateOutcome::Inconclusive])),
    ] {
        let shown = if found.len() > MOST_ANNOTATIONS { MOST_ANNOTATIONS - 1 } else { found.len() };
        annotations.extend(found.iter().take(shown).map(|finding| Annotation {
            level,
            title: format!("rtbench check: {}", finding.outcome.name()),
            text: annotation_text(finding),
        }));
        if shown < found.len() {
            let text = format!("{} more; see the summary", found.len() - shown);
            annotations.push(Annotation { level, title: "rtbench check".into(), text });
        }
    }
    annotations.extend(report.missing_in_words().into_iter().take(MOST_ANNOTATIONS).map(|text| {
        Annotation { level: "warning", title: "rtbench check: not compared".into(), text }
    }));
    annotations
}

fn annotation_text(finding: &Finding) -> String {
    let Finding { quantity, note, .. } = finding;
    let mut text = format!("{}: {quantity}", finding.place());
    if let Some(change) = finding.change {
        text += &format!(" {:+.2}%", (change.median - 1.0) * 100.0);
    }
    if !note.is_empty() {
        text += &format!(" ({note})");
    }
    text
}
