//! Annotations of GitHub Actions, one for each thing that is wrong.

use crate::gate::evidence::{Finding, GateOutcome};
use crate::gate::report::Report;
use presentation::outside::Annotation;

/// GitHub shows no more than that of a level in a step.
const MOST: usize = 10;

/// The annotations of a check: errors for regressions and wrong hits, warnings for what is
/// inconclusive.
pub fn of(report: &Report) -> Vec<Annotation> {
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
        let shown = if found.len() > MOST { MOST - 1 } else { found.len() };
        annotations.extend(found.iter().take(shown).map(|finding| Annotation {
            level,
            title: format!("rtbench check: {}", finding.outcome.name()),
            text: text(finding),
        }));
        if shown < found.len() {
            let text = format!("{} more; see the summary", found.len() - shown);
            annotations.push(Annotation { level, title: "rtbench check".into(), text });
        }
    }
    annotations.extend(report.missing_in_words().into_iter().take(MOST).map(|text| Annotation {
        level: "warning",
        title: "rtbench check: not compared".into(),
        text,
    }));
    annotations
}

fn text(finding: &Finding) -> String {
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
