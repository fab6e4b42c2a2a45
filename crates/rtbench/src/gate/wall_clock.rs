//! Stage: times, by ratios that were measured side by side.
//!
//! Against a record these are ratios to the reference row within each run, so that it does not
//! matter how fast the machines are. It does matter how busy they are: a build of 40 ms is
//! interrupted in most rounds and one of 1 ms in few, so that their ratio follows the load; where
//! threads had to wait for processors, such ratios prove nothing. Against a program they are ratios
//! within each turn, of the same row, which the load moves both ways alike.
//!
//! The rule is that of `compare` ([`statistics::verdict`]), and the noise is no less than the
//! threshold: a regression needs the whole interval beyond it. Where a copy of the program was
//! timed, too, the noise is no less than what that differs by.

use std::collections::BTreeSet;

use crate::comparison::differences::{other_processor, other_reference};
use crate::comparison::pairing::RowPair;
use crate::gate::contest::{self, Key, PairedTimes};
use crate::gate::evidence::{Evidence, Finding, GateOutcome, Stage, Times};
use crate::gate::thresholds::Thresholds;
use measurement::record::metrics::{METRICS, Metric, Reading, series};
use measurement::record::{RowRecord, RunRecord, Sample};
use statistics::estimate::median;
use statistics::mann_whitney::{least_p, samples_needed};
use statistics::ratio_of_medians::FEWEST;
use statistics::verdict::{Change, Rule, Verdict, correct};

pub const STAGE: Stage =
    Stage { name: "times", summary: "build and trace times, as ratios measured together", judge };

/// The times of a row: as printed, and the metric of their ratio to the reference.
fn quantities(evidence: &Evidence<'_>, row: &RowPair<'_>) -> Vec<(&'static str, &'static Metric)> {
    let ratio_of = |kind: &str| {
        let is_own = |m: &&Metric| matches!(m.reading, Reading::RatioOf(own) if own == kind);
        METRICS.iter().find(is_own)
    };
    let kinds = evidence.thresholds.kinds_of(&row.rows[1].label());
    let kinds = kinds.into_iter().filter_map(|kind| Some((kind, ratio_of(kind)?)));
    let whole = [("build", "build-ratio"), ("trace", "ratio")].into_iter();
    let named = |name| METRICS.iter().find(|m| m.name == name);
    whole.filter_map(|(what, name)| Some((what, named(name)?))).chain(kinds).collect()
}

/// The median seconds of one of them.
fn seconds(row: &RowRecord, what: &str) -> Option<f64> {
    let of = |sample: &Sample| match what {
        "build" => Some(sample.build_s),
        "trace" => Some(sample.total_trace_s()),
        kind => sample.trace_s.get(kind).copied(),
    };
    median(series(row, of).values())
}

/// Why nothing is tested; none of the reference, whose ratio to itself says nothing.
type SkipReason = Option<String>;

fn judge(evidence: &Evidence<'_>) -> Vec<Finding> {
    let rows = evidence.rows();
    let mut tested: Vec<(&RowPair<'_>, &'static str, Result<Change, SkipReason>)> = Vec::new();
    for row in &rows {
        for (what, ratio) in quantities(evidence, row) {
            let found = match evidence.times {
                Times::InRun { .. } => in_run(evidence, row, what, ratio),
                Times::Paired { pairs, .. } => {
                    let key = Key::of(row, what);
                    let own = pairs.iter().find(|pair| pair.key == key);
                    own.ok_or_else(|| Some("no times".to_owned())).and_then(|own| {
                        paired(own, evidence.thresholds.shortest, evidence.now.settings.seed)
                    })
                }
            };
            tested.push((row, what, found));
        }
    }
    correct(tested.iter_mut().filter_map(|(_, _, found)| found.as_mut().ok()));
    let findings = tested.into_iter().filter_map(|(row, what, found)| match found {
        Ok(change) => Some(finding(evidence, row, what, &change)),
        Err(why) => Some(Finding::of(STAGE.name, row, what, GateOutcome::NotJudged, why?)),
    });
    findings.collect()
}

/// Rule by which times of `what` are judged: kind of ray, or build.
fn rule(evidence: &Evidence<'_>, row: &RowPair<'_>, what: &str) -> Rule {
    let thresholds = evidence.thresholds;
    let time = thresholds.time_of(&row.rows[1].label(), what);
    let (floor, looks) = match evidence.times {
        Times::Paired { pairs, looks } => (contest::floor(pairs), looks.max(1)),
        Times::InRun { .. } => (evidence.floor(), 1),
    };
    Rule {
        margin: time,
        noise: time.max(floor.map_or(0.0, |floor| floor.floor)),
        significance: thresholds.significance / f64::from(looks),
    }
}

/// Finding about a change whose probability is corrected.
fn finding(
    evidence: &Evidence<'_>,
    row: &RowPair<'_>,
    what: &'static str,
    change: &Change,
) -> Finding {
    let rule = rule(evidence, row, what);
    let (busy, units) = match evidence.times {
        Times::InRun { cpu_pressure, .. } => (cpu_pressure, "rounds"),
        Times::Paired { .. } => (None, "processes"),
    };
    let busy = busy.filter(|share| *share > evidence.thresholds.busiest);
    let (outcome, note) = match (rule.verdict(change), busy) {
        (Verdict::Same, _) => (GateOutcome::Unchanged, String::new()),
        // a row that takes longer than the reference is interrupted more often: its ratio grows
        // with the load
        (_, Some(share)) => {
            let waited = format!("threads waited {:.0}% of the time", share * 100.0);
            let note = format!("the machine was too busy (try --against): {waited}");
            (GateOutcome::Inconclusive, note)
        }
        (Verdict::Slower, _) => (GateOutcome::Regression, String::new()),
        (Verdict::Faster, _) => (GateOutcome::Improved, String::new()),
        (Verdict::Unclear, _) => (GateOutcome::Inconclusive, rule.missing(change, units)),
    };
    Finding {
        baseline: Some(change.old),
        now: Some(change.new),
        change: change.ratio,
        p: change.p,
        ..Finding::of(STAGE.name, row, what, outcome, note)
    }
}

/// The ratio to the reference in both runs.
fn in_run(
    evidence: &Evidence<'_>,
    row: &RowPair<'_>,
    what: &str,
    ratio: &Metric,
) -> Result<Change, SkipReason> {
    let RowPair { scenes, rows } = *row;
    let [before, now] = rows;
    let is_across = matches!(evidence.times, Times::InRun { across_processors: true, .. });
    let processors = other_processor(&evidence.base.machine, &evidence.now.machine);
    if let Some(processors) = processors.filter(|_| !is_across) {
        return Err(Some(format!("another processor: {processors}")));
    }
    if let Some([was, is]) = other_reference(scenes) {
        return Err(Some(format!("ratios were to {was}, are to {is}")));
    }
    if rows.iter().any(|row| row.is_reference) {
        return Err(None);
    }
    long_enough(rows.map(|row| seconds(row, what)), evidence.thresholds.shortest)?;
    let (before, now) = (ratio.values(scenes[0], before), ratio.values(scenes[1], now));
    let change = Change::of_series(&before, &now).filter(|change| change.ratio.is_some());
    change.ok_or_else(|| Some(format!("{} rounds against {} are too few", now.len(), before.len())))
}

/// Times that are short before and now are not judged: what became long is.
fn long_enough(seconds: [Option<f64>; 2], shortest: f64) -> Result<(), SkipReason> {
    let [Some(before), Some(now)] = seconds else {
        return Err(Some("no times".to_owned()));
    };
    if before.max(now) < shortest {
        let longer = before.max(now) * 1e6;
        return Err(Some(format!("too short to time: {longer:.1} us")));
    }
    Ok(())
}

/// The ratio of new to old within each turn.
fn paired(own: &PairedTimes, shortest: f64, seed: u64) -> Result<Change, SkipReason> {
    let pairs: Vec<(u32, [f64; 2])> =
        own.turns().map(|(process, [old, new, _])| (process, [old, new])).collect();
    let change = Change::of_pairs(&pairs, seed);
    let change = change.ok_or_else(|| Some("no times".to_owned()))?;
    long_enough([Some(change.old), Some(change.new)], shortest)?;
    Ok(change)
}

/// Undecided quantities of programs that are measured in turns.
pub fn undecided(evidence: &Evidence<'_>) -> BTreeSet<Key> {
    let of_stage = judge(evidence).into_iter().filter(|f| f.outcome == GateOutcome::Inconclusive);
    of_stage.map(|f| f.key()).collect()
}

/// True where times say that something is a regression: that is measured a second time.
fn is_suspect(finding: &Finding) -> bool {
    finding.stage == STAGE.name && finding.outcome == GateOutcome::Regression
}

/// Scenes in which times say that something is a regression.
pub fn suspects(findings: &[Finding]) -> Vec<String> {
    let suspects = findings.iter().filter(|f| is_suspect(f));
    let mut scenes: Vec<String> = suspects.map(|f| f.scene.clone()).collect();
    scenes.dedup();
    scenes
}

/// The warning that no time can ever be significant in so many rounds, of the baseline and now.
pub fn too_few_rounds(
    thresholds: &Thresholds,
    base: &RunRecord,
    [of_base, asked]: [usize; 2],
) -> Option<String> {
    let rows = base.scenes.iter().flat_map(|scene| &scene.rows);
    let rows = rows.filter(|row| !row.is_reference && row.verdict.is_timed());
    let tests: usize = rows.map(|row| 2 + thresholds.kinds_of(&row.label()).len()).sum();
    let p = least_p(asked, of_base) * tests as f64;
    if asked.min(of_base) >= FEWEST && p < thresholds.significance {
        return None;
    }
    let needed = samples_needed(tests, thresholds.significance);
    Some(format!(
        "{asked} rounds against {of_base} of the baseline can never be significant among {tests} \
         times; measure {needed} against {needed}, or fewer rows (-s)"
    ))
}

/// A regression of times stands where a second measurement finds it again; otherwise nothing is
/// certain. Whatever made only one of two measurements slow, it was not the code.
pub fn confirm(findings: &mut [Finding], second: &[Finding]) {
    for finding in findings.iter_mut().filter(|f| is_suspect(f)) {
        let (stage, key) = (finding.stage, finding.key());
        let again = second.iter().find(|s| s.stage == stage && s.key() == key);
        let seen = again.and_then(|s| s.change);
        let seen = seen.map_or_else(|| "no time".to_owned(), |e| presentation::numbers::ratio(&e));
        let not = if again.is_some_and(is_suspect) { "" } else { "not " };
        if !not.is_empty() {
            finding.outcome = GateOutcome::Inconclusive;
        }
        let seen = seen.trim_end();
        finding.note = format!("{not}found again in a second measurement: {seen}");
    }
}
