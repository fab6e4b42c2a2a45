//! The error of a variant: a rate of wrong answers, or a distance between images.

use serde::{Deserialize, Serialize};

/// How wrong a variant is.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum ErrorOf {
    /// Answers, of which some are wrong.
    Counted { wrong: u64, trials: u64 },
    /// Root of the mean square of the differences to the reference's colours, a channel.
    Rmse {
        /// Error over all pixels.
        rmse: f64,
    },
}

impl ErrorOf {
    /// The number that is plotted: wrong answers in a million, or the difference itself.
    pub fn value(self) -> f64 {
        match self {
            Self::Counted { wrong, trials } => wrong as f64 / trials.max(1) as f64 * 1e6,
            Self::Rmse { rmse } => rmse,
        }
    }

    /// Upper bound of the error rate when none was found: 3 / trials, with 95% confidence.
    pub fn bound(self) -> Option<f64> {
        match self {
            Self::Counted { wrong: 0, trials } => Some(3e6 / trials.max(1) as f64),
            _ => None,
        }
    }
}

#[derive(Debug, Clone, Copy, Default)]
pub struct TrialCounts {
    wrong: u64,
    trials: u64,
}

impl TrialCounts {
    pub fn add(&mut self, is_wrong: bool) {
        self.trials += 1;
        self.wrong += u64::from(is_wrong);
    }

    pub fn add_all(&mut self, wrong: u64, trials: u64) {
        self.trials += trials;
        self.wrong += wrong;
    }

    /// Wrong ones so far.
    pub fn wrong(self) -> u64 {
        self.wrong
    }

    pub fn error(self) -> ErrorOf {
        ErrorOf::Counted { wrong: self.wrong, trials: self.trials }
    }
}
