//! Annotations of GitHub Actions, one for each thing that is wrong.
//!
//! Source: GitHub's documentation, "Workflow commands for GitHub Actions": `::error title=T::text`
//! on a line of its own, with percent signs and line ends escaped, in titles colons and commas too.

use std::io::{self, Write};

use crate::gate::evidence::{Finding, Outcome};
use crate::gate::report::Report;

/// GitHub shows no more than that of a level in a step.
const MOST: usize = 10;

/// Writes the annotations of a check: errors for regressions and wrong hits, warnings for what is
/// inconclusive.
///
/// # Errors
/// Those of the writer.
pub fn write(out: &mut dyn Write, report: &Report) -> io::Result<()> {
    let of = |level: &[Outcome]| -> Vec<&Finding> {
        let mut found: Vec<_> =
            report.findings.iter().filter(|f| level.contains(&f.outcome)).collect();
        found.sort_by_key(|f| std::cmp::Reverse(f.outcome));
        found
    };
    for (level, found) in [
        ("error", of(&[Outcome::WrongHits, Outcome::Regression])),
        ("warning", of(&[Outcome::Inconclusive])),
    ] {
        let shown = if found.len() > MOST { MOST - 1 } else { found.len() };
        for finding in found.iter().take(shown) {
            let title = format!("rtbench check: {}", finding.outcome.name());
            writeln!(out, "::{level} title={}::{}", property(&title), data(&text(finding)))?;
        }
        if shown < found.len() {
            let more = found.len() - shown;
            writeln!(out, "::{level} title=rtbench check::{more} more; see the summary")?;
        }
    }
    Ok(())
}

fn text(finding: &Finding) -> String {
    let Finding { scene, row, quantity, note, .. } = finding;
    let mut text = format!("{scene}: {row}: {quantity}");
    if let Some(change) = finding.change {
        text += &format!(" {:+.2}%", (change.median - 1.0) * 100.0);
    }
    if !note.is_empty() {
        text += &format!(" ({note})");
    }
    text
}

fn data(text: &str) -> String {
    text.replace('%', "%25").replace('\r', "%0D").replace('\n', "%0A")
}

fn property(text: &str) -> String {
    data(text).replace(':', "%3A").replace(',', "%2C")
}
