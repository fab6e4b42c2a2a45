//! Why nothing could be held against a baseline.

use crate::baselines::BaselineError;
use crate::comparison::pairing::{MissingRow, in_words};
use crate::gate::against::AgainstError;
use crate::gate::thresholds::ThresholdError;
use crate::like::LikeError;
use measurement::callgrind::CallgrindError;

/// Why nothing could be held against a baseline.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum GateError {
    /// The baseline says nothing that could be measured anew.
    #[error(transparent)]
    Like(#[from] LikeError),
    /// The folder of baselines.
    #[error(transparent)]
    Baseline(#[from] BaselineError),
    /// Valgrind.
    #[error(transparent)]
    Callgrind(#[from] CallgrindError),
    /// The other binary.
    #[error(transparent)]
    Against(#[from] AgainstError),
    /// The thresholds.
    #[error(transparent)]
    Threshold(#[from] ThresholdError),
    /// Another machine's target, other settings, other scenes.
    #[error("this cannot be compared with the baseline: {}", .0.join("; "))]
    NotComparable(Vec<String>),
    /// No row is in both.
    #[error("nothing was compared: no row is in both; {}", in_words(.0).join("; "))]
    NothingCompared(Vec<MissingRow>),
    /// Instruction counts were asked for, and the baseline has none.
    #[error(
        "the baseline has no instruction counts; save one that has them: `rtbench baseline save \
         NAME --instructions ...`"
    )]
    NoCounts,
}

impl GateError {
    /// What was typed makes no sense.
    pub fn is_usage(&self) -> bool {
        match self {
            Self::Like(error) => matches!(error, LikeError::Unknown { .. }),
            Self::Baseline(error) => error.is_usage(),
            Self::Threshold(_) => true,
            _ => false,
        }
    }
}
