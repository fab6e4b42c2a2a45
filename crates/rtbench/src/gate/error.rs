//! Reasons why no row can be compared with a baseline.

use crate::baselines::BaselineError;
use crate::comparison::pairing::{MissingRow, in_words};
use crate::gate::against::AgainstError;
use crate::gate::thresholds::ThresholdError;
use crate::replan::ReplanError;
use measurement::callgrind::CallgrindError;

/// Reasons why no row can be compared with a baseline.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum GateError {
    #[error(transparent)]
    Like(#[from] ReplanError),
    #[error(transparent)]
    Baseline(#[from] BaselineError),
    #[error(transparent)]
    Callgrind(#[from] CallgrindError),
    #[error(transparent)]
    Against(#[from] AgainstError),
    #[error(transparent)]
    Threshold(#[from] ThresholdError),
    #[error("this cannot be compared with the baseline: {}", .0.join("; "))]
    NotComparable(Vec<String>),
    #[error("nothing was compared: no row is in both; {}", in_words(.0).join("; "))]
    NothingCompared(Vec<MissingRow>),
    #[error(
        "the baseline has no instruction counts; save one that has them: `rtbench baseline save \
         NAME --instructions ...`"
    )]
    NoCounts,
}

impl GateError {
    /// Returns whether the arguments are invalid.
    pub fn is_usage(&self) -> bool {
        match self {
            Self::Like(error) => matches!(error, ReplanError::Unknown { .. }),
            Self::Baseline(error) => error.is_usage(),
            Self::Threshold(_) => true,
            _ => false,
        }
    }
}
