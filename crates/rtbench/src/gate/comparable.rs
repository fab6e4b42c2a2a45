//! May two records be compared at all?

use crate::comparison::differences::{Difference, differences, other_processor};
use measurement::record::RunRecord;
use measurement::record::metrics::DifferenceScope;

/// Reasons why `now` cannot be compared with `base`: all differences that make runs incomparable,
/// except for seconds, which no stage uses, and references, which are compared by scene.
pub fn refusals(base: &RunRecord, now: &RunRecord) -> Vec<String> {
    let refuses = |d: &Difference| d.concerns == DifferenceScope::Everything;
    differences(base, now).into_iter().filter(refuses).map(|d| d.what).collect()
}

/// Remarks that do not prevent a comparison.
pub fn remarks(base: &RunRecord, now: &RunRecord) -> Vec<String> {
    let mut remarks = Vec::new();
    if let Some(processors) = other_processor(&base.machine, &now.machine) {
        remarks.push(format!(
            "Another processor than the baseline's ({processors}): counters and instruction \
             counts are judged as on the same; times only with --across-processors."
        ));
    }
    let (was, is) = (&base.settings.timed_by, &now.settings.timed_by);
    if was != is {
        remarks.push(format!(
            "Times of the baseline are {was}, now {is}: only one of them includes time taken by other programs."
        ));
    }
    if base.compiler.rustc != now.compiler.rustc {
        let of = |r: &RunRecord| r.compiler.rustc.clone().unwrap_or_else(|| "unknown".into());
        remarks.push(format!(
            "Another compiler than the baseline's ({}; was {}): it may change instruction counts.",
            of(now),
            of(base)
        ));
    }
    remarks
}
