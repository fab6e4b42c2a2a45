//! Stage: the exact counters, without any tolerance.
//!
//! They are the same on every machine, so any difference is one of the code. More work or more
//! memory is a regression; less is an improvement, to be kept by saving a new baseline. More empty
//! cells, steps into them or saved tests alone are neither: what they cost is in the counters that
//! they are shares of.

use crate::comparison::entry::exact_ratio;
use crate::comparison::pairing::RowPair;
use crate::gate::evidence::{Evidence, Finding, GateOutcome, Stage};
use measurement::record::metrics::{METRICS, Metric};

pub const STAGE: Stage = Stage {
    name: "counters",
    summary: "exact counters of the structure and of the work of the rays",
    judge,
};

fn judge(evidence: &Evidence<'_>) -> Vec<Finding> {
    let exact: Vec<&Metric> = METRICS.iter().filter(|m| m.is_exact()).collect();
    let rows = evidence.rows();
    rows.iter().flat_map(|row| exact.iter().filter_map(|metric| of(metric, row))).collect()
}

/// Finding about a metric; `None` if neither side has it.
fn of(metric: &Metric, row: &RowPair<'_>) -> Option<Finding> {
    let [base, current] = row.rows;
    let (was, is) = (metric.exact(base), metric.exact(current));
    let finding = |outcome, note: &str| Finding {
        baseline: was,
        now: is,
        ..Finding::of(STAGE.name, row, metric.name, outcome, note)
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
