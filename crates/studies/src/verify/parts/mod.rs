//! Parts of structures that have an oracle of their own: traversals through grids, mailboxes, clouds.
//!
//! A case that concerns a part names its subjects itself ([`Part`]); structures are not asked.

pub mod clouds;
pub mod integer_traversal;
pub mod kernels;
pub mod mailboxes;
pub mod traversals;

use super::mismatch::Mismatch;
use statistics::random::Random;

/// What came of examining a part.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Findings {
    /// Trials made.
    pub trials: u64,
    /// Those that went wrong; `ray` is the index of the trial.
    pub wrong: Vec<Mismatch>,
    /// Departures from the oracle within the tolerance that the case states.
    pub tolerated: u64,
}

impl Findings {
    /// Adds a trial: `Ok` with what is tolerated in it, or what is wrong.
    pub fn record(&mut self, outcome: Result<u64, String>) {
        match outcome {
            Ok(tolerated) => self.tolerated += tolerated,
            Err(what) => self.wrong.push(Mismatch { ray: self.trials as usize, what }),
        }
        self.trials += 1;
    }
}

/// Draws so many trials and makes them.
pub type Examine = fn(&mut Random, usize) -> Findings;

/// A part that a case examines.
#[derive(Debug, Clone, Copy)]
pub struct Part {
    /// Its name: `t-next-traversal`.
    pub name: &'static str,
    /// In single precision.
    pub single: Examine,
    /// In double precision.
    pub double: Examine,
}
