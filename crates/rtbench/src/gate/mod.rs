//! Holding a run against a baseline, in rungs: what is exact first, what is noisy last.
//!
//! A rung looks at the evidence and says of each thing it can judge what became of it. Adding one
//! takes a file and a line in [`RUNGS`].

pub mod against;
pub mod annotations;
pub mod answers;
pub mod command;
pub mod comparable;
pub mod contest;
pub mod counters;
mod error;
mod evidence;
pub mod export;
pub mod instructions;
pub mod report;
pub mod thresholds;
pub mod wall_clock;

pub use contest::ROUNDS;
pub use error::GateError;
pub use evidence::{Evidence, Finding, Instructions, MatchedRow, Outcome, Rung, Times};

/// All rungs, in the order in which they are printed: the surest first.
pub static RUNGS: &[Rung] = &[answers::RUNG, counters::RUNG, instructions::RUNG, wall_clock::RUNG];

/// What all rungs say.
pub fn judge(evidence: &Evidence<'_>) -> Vec<Finding> {
    RUNGS.iter().flat_map(|rung| (rung.judge)(evidence)).collect()
}
