//! Rung: times, by ratios that were measured side by side.
//!
//! Against a record these are ratios to the reference row within each run, so that it does not
//! matter how fast the machines are. It does matter how busy they are: a build of 40 ms is
//! interrupted in most rounds and one of 1 ms in few, so that their ratio follows the load; where
//! threads had to wait for processors, such ratios prove nothing. Against a binary they are ratios
//! within each pair of processes, of the same row, which the load moves both ways alike.
//!
//! A regression needs both: the whole 95% interval beyond the threshold, which says that the
//! change is large, and a test, corrected for all that are tested, which says that it is no
//! chance. An interval that reaches beyond the threshold says that it may be: inconclusive.

use crate::comparison::differences::other_reference;
use crate::gate::against::PairedRow;
use crate::gate::evidence::{Evidence, Finding, MatchedRow, Outcome, Rung, Times};
use measurement::record::SceneRecord;
use measurement::record::metrics::METRICS;
use statistics::estimate::{Estimate, estimate, median};
use statistics::ratio_of_medians::ratio_of_medians;
use statistics::{holm, mann_whitney, sign_test};

/// Registry line.
pub const RUNG: Rung =
    Rung { name: "times", summary: "build and trace times, as ratios measured together", judge };

/// The quantities of a row: as printed, the metric of its ratio, that of its time.
const QUANTITIES: [(&str, &str, &str); 2] =
    [("build", "build-ratio", "build"), ("trace", "ratio", "trace")];

/// What a quantity gave on both sides, and how likely that is without a difference.
struct Tested {
    before: f64,
    now: f64,
    change: Estimate,
    /// Not yet corrected.
    p: f64,
}

fn judge(evidence: &Evidence<'_>) -> Vec<Finding> {
    let rows = evidence.rows();
    let mut tested = Vec::new();
    for row in &rows {
        for (what, ratio, time) in QUANTITIES {
            let found = match evidence.times {
                Times::InRun { .. } => in_run(row, ratio, time, evidence.thresholds.shortest),
                Times::Paired(pairs) => {
                    let own = pairs.iter().find(|p| row.is(&p.scene, &p.structure, &p.settings));
                    paired(own, what, evidence.thresholds.shortest, evidence.now.settings.seed)
                }
            };
            tested.push((row, what, found));
        }
    }
    let p: Vec<f64> = tested.iter().filter_map(|(_, _, t)| t.as_ref().ok().map(|t| t.p)).collect();
    let mut corrected = holm::adjusted(&p).into_iter();
    let findings = tested.into_iter().filter_map(|(row, what, found)| match found {
        Ok(tested) => Some(judged(row, what, &tested, corrected.next()?, evidence)),
        Err(Untested::Reference) => None,
        Err(Untested::Because(why)) => {
            Some(Finding::of(RUNG.name, row, what, Outcome::NotJudged, why))
        }
    });
    findings.collect()
}

/// Why nothing is tested.
enum Untested {
    /// The reference's ratio to itself says nothing.
    Reference,
    Because(String),
}

/// The ratio to the reference in both runs.
fn in_run(
    row: &MatchedRow<'_>,
    ratio: &str,
    time: &str,
    shortest: f64,
) -> Result<Tested, Untested> {
    if let Some([was, is]) = other_reference([row.scene.0, row.scene.1]) {
        return Err(Untested::Because(format!("ratios were to {was}, are to {is}")));
    }
    if row.now.is_reference || row.base.is_reference {
        return Err(Untested::Reference);
    }
    for (scene, own) in [(row.scene.0, row.base), (row.scene.1, row.now)] {
        let reference = scene.rows.iter().find(|r| r.is_reference);
        for timed in std::iter::once(own).chain(reference) {
            long_enough(&values(time, scene, timed), shortest)?;
        }
    }
    let before = values(ratio, row.scene.0, row.base);
    let now = values(ratio, row.scene.1, row.now);
    let tested = || {
        Some(Tested {
            before: median(&before)?,
            now: median(&now)?,
            change: ratio_of_medians(&now, &before)?,
            p: mann_whitney::p_value(&now, &before)?,
        })
    };
    tested().ok_or_else(|| {
        Untested::Because(format!("{} rounds against {} are too few", now.len(), before.len()))
    })
}

fn values(metric: &str, scene: &SceneRecord, row: &measurement::record::RowRecord) -> Vec<f64> {
    let metric = METRICS.iter().find(|m| m.name == metric);
    metric.map(|m| m.values(scene, row)).unwrap_or_default()
}

fn long_enough(seconds: &[f64], shortest: f64) -> Result<(), Untested> {
    match median(seconds) {
        Some(s) if s >= shortest => Ok(()),
        Some(s) => Err(Untested::Because(format!("too short to time: {:.1} us", s * 1e6))),
        None => Err(Untested::Because("no times".into())),
    }
}

/// The ratio of new to old within each pair.
fn paired(
    pairs: Option<&PairedRow>,
    what: &str,
    shortest: f64,
    seed: u64,
) -> Result<Tested, Untested> {
    let pairs = pairs.ok_or_else(|| Untested::Because("no times".into()))?;
    let pairs = if what == "build" { &pairs.build } else { &pairs.trace };
    let (old, new): (Vec<f64>, Vec<f64>) = pairs.iter().map(|[old, new]| (*old, *new)).unzip();
    long_enough(&old, shortest)?;
    let ratios: Vec<f64> = old.iter().zip(&new).map(|(old, new)| new / old).collect();
    let tested = || {
        Some(Tested {
            before: median(&old)?,
            now: median(&new)?,
            change: estimate(&ratios, seed)?,
            p: sign_test::p_value(&ratios, 1.0)?,
        })
    };
    tested().ok_or_else(|| Untested::Because("no times".into()))
}

fn judged(
    row: &MatchedRow<'_>,
    what: &'static str,
    tested: &Tested,
    p: f64,
    evidence: &Evidence<'_>,
) -> Finding {
    let thresholds = evidence.thresholds;
    let (most, least) = (1.0 + thresholds.time, 1.0 / (1.0 + thresholds.time));
    let Estimate { low, high, .. } = tested.change;
    let is_significant = p < thresholds.significance;
    let (outcome, note) = match () {
        () if low > most && is_significant => (Outcome::Regression, ""),
        () if low > most => (Outcome::Inconclusive, "longer, but not significant: more rounds"),
        () if high > most => (Outcome::Inconclusive, "may be longer: more rounds would tell"),
        () if high < least && is_significant => (Outcome::Improved, ""),
        () => (Outcome::Unchanged, ""),
    };
    let (outcome, note) = match evidence.times {
        Times::InRun { cpu_pressure: Some(share) } if share > thresholds.busiest => {
            (if_busy(outcome), format!("{BUSY} {:.0}% of the time", share * 100.0))
        }
        _ => (outcome, note.to_owned()),
    };
    let note = if outcome == Outcome::Unchanged { String::new() } else { note };
    Finding {
        baseline: Some(tested.before),
        now: Some(tested.now),
        change: Some(tested.change),
        p: Some(p),
        ..Finding::of(RUNG.name, row, what, outcome, note)
    }
}

/// What is said where the machine was too busy for ratios within a run.
const BUSY: &str = "the machine was too busy (try --against): threads waited";

/// What is left of a judgement by ratios within a run on a busy machine: a row that takes longer
/// than the reference is interrupted more often, so that its ratio grows with the load.
fn if_busy(outcome: Outcome) -> Outcome {
    match outcome {
        Outcome::Regression => Outcome::Inconclusive,
        Outcome::Improved => Outcome::NotJudged,
        other => other,
    }
}

/// True where times say that something is a regression: that is measured a second time.
pub fn is_suspect(finding: &Finding) -> bool {
    finding.rung == RUNG.name && finding.outcome == Outcome::Regression
}

/// A regression of times stands where a second measurement finds it again; otherwise nothing is
/// certain. Whatever made only one of two measurements slow, it was not the code.
pub fn confirm(findings: &mut [Finding], second: &[Finding]) {
    for finding in findings.iter_mut().filter(|f| is_suspect(f)) {
        let again = second.iter().find(|s| {
            let same = s.scene == finding.scene && s.row == finding.row;
            s.rung == finding.rung && same && s.quantity == finding.quantity
        });
        let seen = again.and_then(|s| s.change);
        let seen = seen.map_or_else(|| "no time".to_owned(), |e| presentation::numbers::ratio(&e));
        if again.is_some_and(is_suspect) {
            finding.note = format!("again in a second measurement: {}", seen.trim_end());
        } else {
            finding.outcome = Outcome::Inconclusive;
            finding.note = format!("not again in a second measurement: {}", seen.trim_end());
        }
    }
}
