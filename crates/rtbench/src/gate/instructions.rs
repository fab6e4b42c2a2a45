//! Stage: instruction counts of the build and of the traversal, by callgrind.
//!
//! They repeat to within a few of a million, whatever else the machine does, so a threshold of half
//! a percent needs no test. What they do not see are cache misses and mispredicted branches. Builds
//! allocate, and what that costs depends on what the process has freed before: builds of 30
//! primitives had 54,489 instructions in eleven of twelve processes and 54,842 in one. So a build
//! also has to differ by [`OF_ALLOCATOR`].

use crate::comparison::entry::exact_ratio;
use crate::comparison::pairing::RowPair;
use crate::gate::evidence::{Evidence, Finding, GateOutcome, Instructions, Stage};
use crate::gate::thresholds::Thresholds;
use measurement::callgrind::CountedRow;
use measurement::record::label;

pub const STAGE: Stage = Stage {
    name: "instructions",
    summary: "instructions of build and traversal, by callgrind",
    judge,
};

fn judge(evidence: &Evidence<'_>) -> Vec<Finding> {
    let rows = evidence.rows();
    match evidence.instructions {
        Instructions::NotAsked => Vec::new(),
        Instructions::Missing(why) => {
            let missing =
                |row| Finding::of(STAGE.name, row, "trace", GateOutcome::Inconclusive, why);
            rows.iter().map(missing).collect()
        }
        Instructions::Counted { base, now } => {
            rows.iter().flat_map(|row| of_row(row, base, now, evidence.thresholds)).collect()
        }
    }
}

fn of_row(
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
    vec![Finding::of(STAGE.name, row, "trace", GateOutcome::NotJudged, note)]
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
        ..Finding::of(STAGE.name, row, what, outcome, "")
    }
}
