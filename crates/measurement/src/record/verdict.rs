//! What is said of a row.

use serde::{Deserialize, Serialize};

/// What is said of a row.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "testing", derive(schemars::JsonSchema))]
pub enum Verdict {
    /// Every answer agrees.
    #[serde(rename = "ok")]
    Ok,
    /// Some answer is wrong: its times are not shown.
    #[serde(rename = "wrong")]
    Wrong,
    /// Some answer is wrong, by a defect that the setting keeps on purpose.
    #[serde(rename = "wrong (as shipped)")]
    WrongAsShipped,
    /// It refused to be built over this scene.
    #[serde(rename = "not built")]
    NotBuilt,
    /// It panicked while it was built, checked or timed, or ended the program.
    #[serde(rename = "panicked")]
    Panicked,
    /// Building it takes more time or memory than it may, at this size or at a smaller one.
    #[serde(rename = "over limit")]
    OverLimit,
    /// It would take more memory than there is for it, by `--max-memory` or by the system.
    #[serde(rename = "out of memory")]
    OutOfMemory,
}

impl Verdict {
    pub fn name(self) -> &'static str {
        match self {
            Self::Ok => "ok",
            Self::Wrong => "wrong",
            Self::WrongAsShipped => "wrong (as shipped)",
            Self::NotBuilt => "not built",
            Self::Panicked => "panicked",
            Self::OverLimit => "over limit",
            Self::OutOfMemory => "out of memory",
        }
    }

    /// True when there was something to judge; else `error` says why not.
    pub fn is_judged(self) -> bool {
        matches!(self, Self::Ok | Self::Wrong | Self::WrongAsShipped)
    }

    /// True when its times may be shown.
    pub fn is_timed(self) -> bool {
        matches!(self, Self::Ok | Self::WrongAsShipped)
    }
}
