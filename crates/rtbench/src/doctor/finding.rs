//! What is said of a thing that was looked at.

use serde::Serialize;

/// What is said of a finding.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Level {
    /// Nothing to do.
    Good,
    /// Measurements suffer from it.
    Warning,
    /// The system does not tell.
    Unknown,
}

impl Level {
    /// As printed.
    pub fn name(self) -> &'static str {
        match self {
            Self::Good => "good",
            Self::Warning => "warning",
            Self::Unknown => "unknown",
        }
    }
}

/// One thing that was looked at.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Finding {
    /// What was looked at.
    pub name: &'static str,
    /// What is said of it.
    pub level: Level,
    /// What was found, in words.
    pub value: String,
    /// What it means for measurements.
    pub meaning: &'static str,
    /// What to do; only of warnings.
    pub advice: Option<&'static str>,
}
