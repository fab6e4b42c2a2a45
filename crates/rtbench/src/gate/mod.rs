//! Comparison of a run with a baseline, in stages: what is exact first, what is noisy last.
//!
//! A stage looks at the evidence and says of each thing it can judge what became of it. Adding one
//! takes a line in [`STAGES`].

pub mod against;
// programs by their places, rows by theirs
#[allow(clippy::indexing_slicing)]
pub mod contest;
mod evidence;
pub mod exact;
pub mod report;
pub mod thresholds;
pub mod wall_clock;

pub use against::ROUNDS;
pub use evidence::{Evidence, Finding, GateOutcome, Instructions, Stage, Times};

use crate::comparison::differences::refusals;
use crate::error::Error;
use measurement::record::{RunRecord, Verdict};

/// All stages, in the order in which they are printed: the surest first.
pub static STAGES: &[Stage] =
    &[exact::ANSWERS, exact::COUNTERS, exact::INSTRUCTIONS, wall_clock::STAGE];

pub fn judge(evidence: &Evidence<'_>) -> Vec<Finding> {
    STAGES.iter().flat_map(|stage| (stage.judge)(evidence)).collect()
}

/// Refuses what cannot be compared; wrong hits are said first, whatever the settings.
pub fn refuse(base: &RunRecord, now: &RunRecord) -> Result<(), Error> {
    let reasons = refusals(base, now);
    let is_wrong = now.scenes.iter().flat_map(|s| &s.rows).any(|r| r.verdict == Verdict::Wrong);
    if reasons.is_empty() || is_wrong { Ok(()) } else { Err(Error::NotComparable(reasons)) }
}
