//! Stage: times, by ratios that were measured side by side.
//!
//! Against a record these are ratios to the reference row within each run, so that it does not
//! matter how fast the machines are. It does matter how busy they are: a build of 40 ms is
//! interrupted in most rounds and one of 1 ms in few, so that their ratio follows the load; where
//! threads had to wait for processors, such ratios prove nothing. Against a binary they are ratios
//! within each pair of processes, of the same row, which the load moves both ways alike.
//!
//! A regression needs both: the whole 95% interval beyond the threshold, which says that the
//! change is large, and a test, corrected for all that are tested, which says that it is no
//! chance. An interval that reaches beyond the threshold says that it may be: inconclusive. Where a copy of
//! the program was timed, too, the threshold is no less than what that differs by.

use crate::comparison::differences::other_reference;
use crate::gate::contest::{self, PairedTimes};
use crate::gate::evidence::{Evidence, Finding, MatchedRow, Outcome, Stage, Times};
use crate::gate::thresholds::Thresholds;
use measurement::record::metrics::METRICS;
use measurement::record::{FloorRecord, SceneRecord};
use statistics::estimate::{Estimate, estimate, median};
use statistics::series::{Series, p_value, ratio_of};
use statistics::{holm, sign_test};

/// Registry line.
pub const STAGE: Stage =
    Stage { name: "times", summary: "build and trace times, as ratios measured together", judge };

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
    let shortest = evidence.thresholds.shortest;
    let mut tested = Vec::new();
    for row in &rows {
        let (scene, label) = (&*row.scene.1.name, row.now.label());
        for (what, ratio, time) in QUANTITIES {
            let found = match evidence.times {
                Times::InRun { .. } => in_run(row, ratio, time, shortest),
                Times::Paired(pairs) => {
                    let is_own = |p: &&PairedTimes| {
                        p.key.scene == scene && p.key.row == label && p.key.quantity == what
                    };
                    let own = pairs.iter().find(is_own);
                    own.ok_or_else(|| Untested::Because("no times".into()))
                        .and_then(|own| paired(own, shortest, evidence.now.settings.seed))
                }
            };
            tested.push(((scene, label.clone(), what), found));
        }
    }
    let floor = match evidence.times {
        Times::Paired(pairs) => contest::floor(pairs),
        Times::InRun { .. } => evidence.floor(),
    };
    let busy = match evidence.times {
        Times::InRun { cpu_pressure } => cpu_pressure,
        Times::Paired(_) => None,
    };
    Bar { thresholds: evidence.thresholds, floor: floor.as_ref(), busy }.findings(tested)
}

/// What is said of times that any programs printed, in turns.
pub fn judge_times(pairs: &[PairedTimes], thresholds: &Thresholds, seed: u64) -> Vec<Finding> {
    let tested = pairs.iter().map(|own| {
        let contest::Key { scene, row, quantity } = &own.key;
        ((&**scene, row.clone(), *quantity), paired(own, thresholds.shortest, seed))
    });
    let floor = contest::floor(pairs);
    Bar { thresholds, floor: floor.as_ref(), busy: None }.findings(tested.collect())
}

/// Scene, row, quantity.
type Named<'a> = (&'a str, String, &'static str);

/// What a difference has to be beyond.
struct Bar<'a> {
    thresholds: &'a Thresholds,
    /// How far a copy of the program is from it.
    floor: Option<&'a FloorRecord>,
    /// The share of the time in which some thread waited, where that counts.
    busy: Option<f64>,
}

impl Bar<'_> {
    fn findings(&self, tested: Vec<(Named<'_>, Result<Tested, Untested>)>) -> Vec<Finding> {
        let p: Vec<f64> = tested.iter().filter_map(|(_, t)| t.as_ref().ok().map(|t| t.p)).collect();
        let mut corrected = holm::adjusted(&p).into_iter();
        let findings = tested.into_iter().filter_map(|((scene, row, what), found)| match found {
            Ok(tested) => {
                let p = corrected.next()?;
                let (outcome, note) = self.judged(&tested, p);
                let note = if outcome == Outcome::Unchanged { String::new() } else { note };
                Some(Finding {
                    baseline: Some(tested.before),
                    now: Some(tested.now),
                    change: Some(tested.change),
                    p: Some(p),
                    ..Finding::named(STAGE.name, scene, row, what, outcome, note)
                })
            }
            Err(Untested::Reference) => None,
            Err(Untested::Because(why)) => {
                Some(Finding::named(STAGE.name, scene, row, what, Outcome::NotJudged, why))
            }
        });
        findings.collect()
    }

    fn judged(&self, tested: &Tested, p: f64) -> (Outcome, String) {
        let thresholds = self.thresholds;
        let floor = self.floor.map_or(0.0, |floor| floor.floor);
        let above = thresholds.time.max(floor);
        let (most, least) = (1.0 + above, 1.0 / (1.0 + above));
        let Estimate { low, high, .. } = tested.change;
        let is_significant = p < thresholds.significance;
        let (outcome, note) = match () {
            () if low > most && is_significant => (Outcome::Regression, ""),
            () if low > most => (Outcome::Inconclusive, "longer, but not significant: more rounds"),
            () if low > 1.0 + thresholds.time => {
                (Outcome::Inconclusive, "longer, but not beyond the A/A floor")
            }
            () if high > most => (Outcome::Inconclusive, "may be longer: more rounds would tell"),
            () if high < least && is_significant => (Outcome::Improved, ""),
            () => (Outcome::Unchanged, ""),
        };
        match self.busy {
            Some(share) if share > thresholds.busiest => {
                (if_busy(outcome), format!("{BUSY} {:.0}% of the time", share * 100.0))
            }
            _ => (outcome, note.to_owned()),
        }
    }
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
            long_enough(values(time, scene, timed).values(), shortest)?;
        }
    }
    let before = values(ratio, row.scene.0, row.base);
    let now = values(ratio, row.scene.1, row.now);
    let tested = || {
        Some(Tested {
            before: before.middle()?,
            now: now.middle()?,
            change: ratio_of(&now, &before)?,
            p: p_value(&now, &before)?,
        })
    };
    tested().ok_or_else(|| {
        Untested::Because(format!("{} rounds against {} are too few", now.len(), before.len()))
    })
}

fn values(metric: &str, scene: &SceneRecord, row: &measurement::record::RowRecord) -> Series {
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

/// The ratio of new to old within each turn.
fn paired(own: &PairedTimes, shortest: f64, seed: u64) -> Result<Tested, Untested> {
    let (old, new): (Vec<f64>, Vec<f64>) =
        own.times.iter().map(|[old, new, _]| (*old, *new)).unzip();
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
    finding.stage == STAGE.name && finding.outcome == Outcome::Regression
}

/// A regression of times stands where a second measurement finds it again; otherwise nothing is
/// certain. Whatever made only one of two measurements slow, it was not the code.
pub fn confirm(findings: &mut [Finding], second: &[Finding]) {
    for finding in findings.iter_mut().filter(|f| is_suspect(f)) {
        let again = second.iter().find(|s| {
            let same = s.scene == finding.scene && s.row == finding.row;
            s.stage == finding.stage && same && s.quantity == finding.quantity
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
