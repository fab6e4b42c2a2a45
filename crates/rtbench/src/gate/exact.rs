//! The stages that need no statistics: answers, exact counters, instruction counts.

use std::fmt::Display;

use crate::comparison::entry::exact_ratio;
use crate::comparison::pairing::RowPair;
use crate::gate::evidence::{Evidence, Finding, GateOutcome, Instructions, Stage};
use crate::gate::thresholds::Thresholds;
use measurement::callgrind::CountedRow;
use measurement::record::metrics::{METRICS, Metric};
use measurement::record::{Verdict, label};

/// Are the answers right, and still the same? Wrong hits are judged by the run itself, against its
/// oracle. Beyond that the hashes of all answers must be those of the baseline: ids and every bit of
/// t.
pub const ANSWERS: Stage = Stage {
    name: "answers",
    summary: "no wrong hits; all answers as in the baseline",
    judge: judge_answers,
};

fn judge_answers(evidence: &Evidence<'_>) -> Vec<Finding> {
    let of_row = |row: &RowPair<'_>| {
        let (outcome, note) = answers_of(row);
        Finding::of(ANSWERS.name, row, "answers", outcome, note)
    };
    evidence.rows().iter().map(of_row).collect()
}

fn answers_of(row: &RowPair<'_>) -> (GateOutcome, String) {
    let [base, now] = row.rows;
    let was_and_is = |was: &dyn Display, is: &dyn Display| format!("was {was}, is {is}");
    let verdicts = || was_and_is(&base.verdict.name(), &now.verdict.name());
    match now.verdict {
        Verdict::Wrong => {
            let (wrong, rays) = (now.mismatches, now.checked_rays);
            let example = now.example.as_deref().unwrap_or("no example");
            return (GateOutcome::WrongHits, format!("{wrong} of {rays} rays: {example}"));
        }
        v if !v.is_judged() => {
            let why = now.error.as_deref().unwrap_or(now.verdict.name());
            return if base.verdict == now.verdict {
                (GateOutcome::NotJudged, format!("{}: {why}", now.verdict.name()))
            } else {
                (GateOutcome::Regression, format!("{}: {why}", verdicts()))
            };
        }
        _ => {}
    }
    if now.mismatches > base.mismatches && now.checked_rays == base.checked_rays {
        let change = was_and_is(&base.mismatches, &now.mismatches);
        return (GateOutcome::Regression, format!("wrong hits by design: {change}"));
    }
    if now.verdict != base.verdict {
        return (GateOutcome::Improved, verdicts());
    }
    if base.checked_rays != now.checked_rays {
        let change = was_and_is(&base.checked_rays, &now.checked_rays);
        return (GateOutcome::NotJudged, format!("other rays were checked: {change}"));
    }
    match (&base.answers_sha256, &now.answers_sha256) {
        (Some(was), Some(is)) if was == is => (GateOutcome::Unchanged, String::new()),
        (Some(_), Some(_)) => (
            GateOutcome::Regression,
            "answers differ from the baseline's, though none is wrong".to_owned(),
        ),
        _ => (GateOutcome::NotJudged, "the baseline has no hash of answers".to_owned()),
    }
}

/// The exact counters, without any tolerance. They are the same on every machine, so any difference
/// is one of the code. More work or more memory is a regression; less is an improvement, to be kept
/// by saving a new baseline. More empty cells, steps into them or saved tests alone are neither:
/// what they cost is in the counters that they are shares of.
pub const COUNTERS: Stage = Stage {
    name: "counters",
    summary: "exact counters of the structure and of the work of the rays",
    judge: judge_counters,
};

fn judge_counters(evidence: &Evidence<'_>) -> Vec<Finding> {
    let exact: Vec<&Metric> = METRICS.iter().filter(|m| m.is_exact()).collect();
    let rows = evidence.rows();
    rows.iter().flat_map(|row| exact.iter().filter_map(|metric| counter_of(metric, row))).collect()
}

/// Finding about a metric; `None` if neither side has it.
fn counter_of(metric: &Metric, row: &RowPair<'_>) -> Option<Finding> {
    let [base, current] = row.rows;
    let (was, is) = (metric.exact(base), metric.exact(current));
    let finding = |outcome, note: &str| Finding {
        baseline: was,
        now: is,
        ..Finding::of(COUNTERS.name, row, metric.name, outcome, note)
    };
    let (before, now) = match (was, is) {
        (Some(before), Some(now)) => (before, now),
        (None, None) => return None,
        // whether it was built is judged with its answers
        _ => return Some(finding(GateOutcome::NotJudged, "one side has none")),
    };
    let [before_rays, now_rays] = row.rows.map(|row| row.work.as_ref().map(|work| work.rays));
    if before_rays != now_rays {
        return Some(finding(GateOutcome::NotJudged, "other rays were counted"));
    }
    if !metric.is_cost && before != now {
        let note = "changed; not a cost by itself, but part of one";
        return Some(finding(GateOutcome::NotJudged, note));
    }
    if before > 0.0 && now == 0.0 {
        let note = "nothing was counted: less work, or no longer counted";
        return Some(finding(GateOutcome::NotJudged, note));
    }
    let outcome = match before.total_cmp(&now) {
        std::cmp::Ordering::Less => GateOutcome::Regression,
        std::cmp::Ordering::Equal => GateOutcome::Unchanged,
        std::cmp::Ordering::Greater => GateOutcome::Improved,
    };
    Some(Finding { change: exact_ratio(before, now), ..finding(outcome, "") })
}

/// Instruction counts of the build and of the traversal, by callgrind. They repeat to within a few of
/// a million, whatever else the machine does, so a threshold of half a percent needs no test. What
/// they do not see are cache misses and mispredicted branches. Builds allocate, and what that costs
/// depends on what the process has freed before: builds of 30 primitives had 54,489 instructions in
/// eleven of twelve processes and 54,842 in one. So a build also has to differ by [`OF_ALLOCATOR`].
pub const INSTRUCTIONS: Stage = Stage {
    name: "instructions",
    summary: "instructions of build and traversal, by callgrind",
    judge: judge_instructions,
};

fn judge_instructions(evidence: &Evidence<'_>) -> Vec<Finding> {
    let rows = evidence.rows();
    match evidence.instructions {
        Instructions::NotAsked => Vec::new(),
        Instructions::Missing(why) => {
            let missing =
                |row| Finding::of(INSTRUCTIONS.name, row, "trace", GateOutcome::Inconclusive, why);
            rows.iter().map(missing).collect()
        }
        Instructions::Counted { base, now } => {
            rows.iter().flat_map(|row| counts_of(row, base, now, evidence.thresholds)).collect()
        }
    }
}

fn counts_of(
    row: &RowPair<'_>,
    base: &[CountedRow],
    now: &[CountedRow],
    thresholds: &Thresholds,
) -> Vec<Finding> {
    let of = |counted: &[CountedRow]| {
        let [scene, own] = [&row.scenes[1].name, &row.rows[1].label()];
        let is_own =
            |c: &&CountedRow| c.scene == *scene && label(&c.structure, &c.settings) == *own;
        counted.iter().find(is_own).cloned()
    };
    let note = match (of(base), of(now)) {
        (Some(before), Some(now)) if before.rays != now.rays => "other rays were counted",
        (Some(before), Some(now)) => {
            let both = [("build", before.build, now.build), ("trace", before.trace, now.trace)];
            let found = both.into_iter().filter_map(|(what, before, now)| {
                let threshold = thresholds.instructions_of(&row.rows[1].label(), what);
                Some(compared(row, what, before? as f64, now? as f64, threshold))
            });
            return found.collect();
        }
        (None, _) => "the baseline does not have this count",
        (_, None) => "not counted now",
    };
    vec![Finding::of(INSTRUCTIONS.name, row, "trace", GateOutcome::NotJudged, note)]
}

/// Instructions by which two builds may differ, however few they have.
const OF_ALLOCATOR: f64 = 1000.0;

fn compared(
    row: &RowPair<'_>,
    what: &'static str,
    before: f64,
    now: f64,
    threshold: f64,
) -> Finding {
    let ratio = now / before.max(1.0);
    let is_chance = what == "build" && (now - before).abs() < OF_ALLOCATOR;
    let outcome = match ratio {
        _ if is_chance => GateOutcome::Unchanged,
        r if r > 1.0 + threshold => GateOutcome::Regression,
        r if r < 1.0 / (1.0 + threshold) => GateOutcome::Improved,
        _ => GateOutcome::Unchanged,
    };
    Finding {
        baseline: Some(before),
        now: Some(now),
        change: exact_ratio(before.max(1.0), now),
        ..Finding::of(INSTRUCTIONS.name, row, what, outcome, "")
    }
}
